#include "runs/decomposition.h"

#include <algorithm>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>

#include "file_error.h"

namespace insitu_replay {

namespace {

using Grids = std::vector<vtkSmartPointer<vtkUnstructuredGrid>>;

/// Where in the pieces an item of the whole is.
struct Place {
  std::int32_t piece = -1;
  vtkIdType at = 0;
};

/// The places of all numbers, of which the first piece counts. once: no number may come again.
std::vector<Place> places_of(const std::vector<PieceNumbers>& pieces, bool once) {
  std::size_t most = 0;
  std::int64_t last = -1;
  for (const PieceNumbers& piece : pieces) {
    most += piece.numbers.size();
    for (const std::int64_t number : piece.numbers)
      last = std::max(last, number);
  }
  std::vector<Place> out(once ? most : std::min(most, std::size_t(last + 1)));
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (std::size_t i = 0; i < pieces[p].numbers.size(); ++i) {
      const std::int64_t number = pieces[p].numbers[i];
      if (number < 0 || std::size_t(number) >= out.size())
        throw FileError(pieces[p].file, "label " + std::to_string(i) + " is " +
                                            std::to_string(number) + ", 0 to " +
                                            std::to_string(out.size() - 1) + " expected");
      Place& place = out[std::size_t(number)];
      if (place.piece < 0)
        place = {std::int32_t(p), vtkIdType(i)};
      else if (once)
        throw FileError(pieces[p].file, "label " + std::to_string(i) + " is " +
                                            std::to_string(number) + ", as label " +
                                            std::to_string(place.at) + " of " +
                                            pieces[std::size_t(place.piece)].file + " is");
    }
  const auto none =
      std::find_if(out.begin(), out.end(), [](const Place& p) { return p.piece < 0; });
  if (none != out.end())
    throw FileError(pieces.empty() ? "" : pieces[0].file,
                    "and those of the other processors do not have the label " +
                        std::to_string(none - out.begin()));
  return out;
}

/// Takes the arrays that all pieces have.
void take_arrays(const Grids& pieces, const std::vector<Place>& places, bool of_cells,
                 vtkUnstructuredGrid* out, std::set<std::string>& left_out) {
  const auto attributes = [&](vtkUnstructuredGrid* grid) -> vtkDataSetAttributes* {
    if (of_cells)
      return grid->GetCellData();
    return grid->GetPointData();
  };
  std::set<std::string> names;
  for (const auto& piece : pieces)
    for (int a = 0; a < attributes(piece)->GetNumberOfArrays(); ++a)
      if (const char* const name = attributes(piece)->GetArrayName(a))
        names.insert(name);
  for (const std::string& name : names) {
    std::vector<vtkDataArray*> from;
    vtkDataArray* model = nullptr;
    bool alike = true;
    for (const auto& piece : pieces) {
      vtkDataArray* const own = attributes(piece)->GetArray(name.c_str());
      from.push_back(own);
      if ((of_cells ? piece->GetNumberOfCells() : piece->GetNumberOfPoints()) == 0)
        continue; // it has nothing to give
      model = model ? model : own;
      alike = alike && own && own->GetNumberOfComponents() == model->GetNumberOfComponents() &&
              own->GetDataType() == model->GetDataType();
    }
    if (!model || !alike) {
      left_out.insert(name);
      continue;
    }
    const auto array = vtkSmartPointer<vtkDataArray>::Take(model->NewInstance());
    array->SetName(name.c_str());
    array->SetNumberOfComponents(model->GetNumberOfComponents());
    array->SetNumberOfTuples(vtkIdType(places.size()));
    for (std::size_t i = 0; i < places.size(); ++i)
      array->SetTuple(vtkIdType(i), places[i].at, from[std::size_t(places[i].piece)]);
    attributes(out)->AddArray(array);
  }
}

/// A cell's points, or a polyhedron's faces, by the numbers of the whole.
void take_cell(vtkUnstructuredGrid* piece, vtkIdType cell, const std::vector<std::int64_t>& points,
               vtkIdList* ids, vtkUnstructuredGrid* out) {
  const int type = piece->GetCellType(cell);
  const auto number = [&](vtkIdType id) { return vtkIdType(points[std::size_t(id)]); };
  if (type != VTK_POLYHEDRON) {
    piece->GetCellPoints(cell, ids);
    for (vtkIdType i = 0; i < ids->GetNumberOfIds(); ++i)
      ids->SetId(i, number(ids->GetId(i)));
  } else {
    piece->GetFaceStream(cell, ids); // the number of faces; of each how many points, and which
    for (vtkIdType i = 1; i < ids->GetNumberOfIds();) {
      const vtkIdType end = i + 1 + ids->GetId(i);
      for (++i; i < end; ++i)
        ids->SetId(i, number(ids->GetId(i)));
    }
  }
  out->InsertNextCell(type, ids);
}

} // namespace

vtkSmartPointer<vtkUnstructuredGrid> put_together(const Grids& pieces, const Numbers& numbers,
                                                  std::set<std::string>& left_out) {
  const std::vector<Place> cells = places_of(numbers.cells, true),
                           points = places_of(numbers.points, false);
  auto out = vtkSmartPointer<vtkUnstructuredGrid>::New();
  const vtkNew<vtkPoints> made;
  const auto filled = std::find_if(pieces.begin(), pieces.end(),
                                   [](const auto& piece) { return piece->GetPoints(); });
  made->SetDataType(filled == pieces.end() ? VTK_DOUBLE : (*filled)->GetPoints()->GetDataType());
  made->SetNumberOfPoints(vtkIdType(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i)
    made->SetPoint(vtkIdType(i), pieces[std::size_t(points[i].piece)]->GetPoint(points[i].at));
  out->SetPoints(made);
  out->Allocate(vtkIdType(cells.size()));
  const vtkNew<vtkIdList> ids;
  for (const Place& cell : cells)
    take_cell(pieces[std::size_t(cell.piece)], cell.at,
              numbers.points[std::size_t(cell.piece)].numbers, ids, out);
  take_arrays(pieces, cells, true, out, left_out);
  take_arrays(pieces, points, false, out, left_out);
  return out;
}

} // namespace insitu_replay
