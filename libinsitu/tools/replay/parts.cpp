#include "parts.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDataSet.h>
#include <vtkDataSetAttributes.h>
#include <vtkGenericCell.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include "read.h"
#include "runs/runs_of_others.h"

namespace insitu_replay {

namespace {

int dimension_of(unsigned char type) {
  const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(type));
  return cell ? cell->GetCellDimension() : 3; // what is unknown is refused later, by name
}

/// Whether it has cells, and none of them has a volume.
bool is_surface(vtkDataObject* data) {
  auto* const set = vtkDataSet::SafeDownCast(data);
  if (!set || set->GetNumberOfCells() == 0)
    return false;
  if (vtkPolyData::SafeDownCast(set))
    return true;
  if (auto* grid = vtkUnstructuredGrid::SafeDownCast(set)) {
    vtkUnsignedCharArray* const types = grid->GetCellTypesArray();
    bool seen[256] = {};
    for (vtkIdType c = 0; c < types->GetNumberOfValues(); ++c)
      seen[types->GetValue(c)] = true;
    for (int type = 0; type < 256; ++type)
      if (seen[type] && dimension_of(static_cast<unsigned char>(type)) > 2)
        return false;
    return true;
  }
  if (auto* image = vtkImageData::SafeDownCast(set))
    return image->GetDataDimension() < 3;
  if (auto* grid = vtkRectilinearGrid::SafeDownCast(set))
    return grid->GetDataDimension() < 3;
  if (auto* grid = vtkStructuredGrid::SafeDownCast(set))
    return grid->GetDataDimension() < 3;
  return false;
}

bool has_cells(const Part& part) {
  auto* const set = vtkDataSet::SafeDownCast(part.data);
  return set && set->GetNumberOfCells() > 0;
}

} // namespace

std::vector<Part> read_parts(const std::string& path, const Step& step) {
  const vtkSmartPointer<vtkDataObject> data =
      step.is_of_run ? read_run(path, step.time) : read(path);
  auto* const tree = vtkDataObjectTree::SafeDownCast(data);
  if (!tree)
    return {{path, data}};
  std::vector<Part> parts;
  const auto leaves = vtkSmartPointer<vtkDataObjectTreeIterator>::New();
  leaves->SetDataSet(tree);
  leaves->VisitOnlyLeavesOn();
  leaves->TraverseSubTreeOn();
  leaves->SkipEmptyNodesOn();
  for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem()) {
    vtkInformation* const about =
        leaves->HasCurrentMetaData() ? leaves->GetCurrentMetaData() : nullptr;
    const char* const name = about ? about->Get(vtkCompositeDataSet::NAME()) : nullptr;
    parts.push_back(
        {path + ", block " +
             (name ? "'" + std::string(name) + "'" : std::to_string(leaves->GetCurrentFlatIndex())),
         leaves->GetCurrentDataObject()});
  }
  // The blocks' field data, time and cycle among them, stands in the file's.
  if (!parts.empty() && !cycle_of(parts[0].data) && !time_of(parts[0].data))
    parts[0].data->SetFieldData(data->GetFieldData());
  return parts;
}

void drop_surfaces(std::vector<Part>& parts, const Say& say) {
  std::vector<Part> left_out;
  vtkIdType cells = 0;
  for (const Part& part : parts)
    if (is_surface(part.data)) {
      left_out.push_back(part);
      cells += vtkDataSet::SafeDownCast(part.data)->GetNumberOfCells();
    }
  if (left_out.empty() || left_out.size() == parts.size())
    return; // surfaces alone are a flat mesh
  const vtkSmartPointer<vtkFieldData> about = parts[0].data->GetFieldData();
  const bool first_goes = is_surface(parts[0].data);
  parts.erase(std::remove_if(parts.begin(), parts.end(),
                             [](const Part& part) { return is_surface(part.data); }),
              parts.end());
  if (first_goes && !cycle_of(parts[0].data) && !time_of(parts[0].data))
    parts[0].data->SetFieldData(about);
  say(left_out[0].name +
      (left_out.size() > 1 ? " and " + std::to_string(left_out.size() - 1) + " more parts, "
                           : ", ") +
      std::to_string(cells) + " cells without volume beside cells of volume, are left out");
}

void keep_common_arrays(const std::vector<Part>& parts, const Say& say) {
  using Key = std::tuple<int, std::string, int>; // association, name, components
  std::map<Key, std::size_t> count;
  std::size_t full = 0;
  const auto visit = [&](const Part& part, auto&& act) {
    for (const int association : {vtkDataObject::POINT, vtkDataObject::CELL}) {
      vtkDataSetAttributes* const arrays = part.data->GetAttributes(association);
      for (int i = arrays->GetNumberOfArrays() - 1; i >= 0; --i) {
        vtkAbstractArray* const a = arrays->GetAbstractArray(i);
        const std::string name = a->GetName() ? a->GetName() : "";
        if (!name.empty() && name != vtkDataSetAttributes::GhostArrayName())
          act(arrays, Key{association, name, a->GetNumberOfComponents()});
      }
    }
  };
  for (const Part& part : parts)
    if (has_cells(part)) {
      ++full;
      visit(part, [&](vtkDataSetAttributes*, const Key& key) { ++count[key]; });
    }
  if (full < 2)
    return;
  for (const Part& part : parts)
    if (has_cells(part))
      visit(part, [&](vtkDataSetAttributes* arrays, const Key& key) {
        if (count[key] < full)
          arrays->RemoveArray(std::get<1>(key).c_str());
      });
  for (const auto& [key, n] : count)
    if (n < full)
      say(std::string(std::get<0>(key) == vtkDataObject::POINT ? "point" : "cell") + " array '" +
          std::get<1>(key) + "' is left out: " + std::to_string(n) + " of " + std::to_string(full) +
          " parts have it alike");
}

std::vector<std::string> field_names_of(const std::vector<Part>& parts) {
  std::set<std::string> names;
  for (const Part& part : parts)
    if (has_cells(part))
      for (const int association : {vtkDataObject::POINT, vtkDataObject::CELL}) {
        vtkDataSetAttributes* const arrays = part.data->GetAttributes(association);
        for (int i = 0; arrays && i < arrays->GetNumberOfArrays(); ++i)
          if (const vtkDataArray* const a = arrays->GetArray(i);
              a && arrays->GetArrayName(i) &&
              arrays->GetArrayName(i) != std::string(vtkDataSetAttributes::GhostArrayName()))
            names.insert(arrays->GetArrayName(i));
      }
  return {names.begin(), names.end()};
}

} // namespace insitu_replay
