#include <algorithm>
#include <map>
#include <vtkCellData.h>
#include <vtkDataSetAttributes.h>
#include <vtkHyperTreeGrid.h>
#include <vtkPointData.h>

#include "insitu/vtk.hpp"

#include "adaptive_cells.h"
#include "arrays.h"

namespace insitu::vtk {

namespace {

/// A field of one piece that was given, with what owns its values.
struct Given {
  Watched source;
  Adopted adopted;
  std::vector<std::vector<const void*>> places; ///< of leaves: where each one's values are
};

using Pieces = std::vector<Given>;

int bytes_of(const Array& a) {
  return a.type() == INSITU_FLOAT32 ? 4 : 8;
}

Array at_address(const Array& like, const std::byte* data) {
  if (like.type() == INSITU_FLOAT32)
    return Array(reinterpret_cast<const float*>(data)).components(like.components());
  return Array(reinterpret_cast<const double*>(data)).components(like.components());
}

/// The patch's part of an array over the whole grid.
Array part_of(const Array& whole, const AdaptivePatch& p, const char* reason) {
  const std::int64_t i = bytes_of(whole) * whole.components();
  const std::int64_t j = i * p.grid_cells[0], k = j * p.grid_cells[1];
  const auto* const data = static_cast<const std::byte*>(whole.data()) + i * p.skipped[0] +
                           j * p.skipped[1] + k * p.skipped[2];
  return at_address(whole, data).block(p.cells, {i, j, k}).converted(reason);
}

/// An array over all nodes of the trees, read at the leaves' alone.
Array at_leaves(const Array& nodes, const AdaptiveLeaves& leaves, const char* reason,
                std::vector<const void*>& places) {
  places.clear();
  for (const vtkIdType node : leaves.nodes)
    places.push_back(static_cast<const std::byte*>(nodes.data()) +
                     node * bytes_of(nodes) * nodes.components());
  const auto n = static_cast<std::int64_t>(places.size());
  Array out = nodes.type() == INSITU_FLOAT32 ? Array::behind<float>(places.data(), 0)
                                             : Array::behind<double>(places.data(), 0);
  return out.count(n).components(nodes.components()).converted(reason);
}

} // namespace

struct AdaptiveAttachment::State {
  State(const Mesh& m, const AttachOptions& o) : mesh(m), options(o) {}

  Change update(vtkDataObject* data);

  Mesh mesh;
  AttachOptions options;
  bool attached = false;
  AdaptiveCells cells;
  std::map<std::string, Pieces> given;
  std::vector<Note> converted, skipped;

private:
  void give_cells(AdaptiveCells next);
  bool give(const std::string& name, const std::vector<vtkDataArray*>& arrays, bool elsewhere);
  bool remove_others(const std::map<std::string, std::vector<vtkDataArray*>>& now);
  std::map<std::string, std::vector<vtkDataArray*>> collect(vtkDataObject* data);
  bool accepts(vtkDataArray* array, const std::string& name);
  std::size_t piece_count() const { return cells.are_leaves ? 1 : cells.patches.size(); }
};

void AdaptiveAttachment::State::give_cells(AdaptiveCells next) {
  mesh.adaptive(next.levels);
  if (next.are_leaves) {
    const auto n = static_cast<std::int64_t>(next.leaves.levels.size());
    const char* const reason = "hyper trees keep no corners of leaves";
    mesh.leaves(Array(next.leaves.levels.data(), n).converted(reason),
                Array(next.leaves.corners.data(), n).components(3).converted(reason));
  }
  for (std::size_t p = 0; p < next.patches.size(); ++p)
    mesh.piece(static_cast<int>(p))
        .patch(next.patches[p].level, next.patches[p].lower, next.patches[p].cells);
  mesh.drop_pieces(next.are_leaves ? 1 : static_cast<int>(next.patches.size()));
  cells = std::move(next); // its arrays keep their places
  for (auto& [name, pieces] : given)
    pieces.resize(piece_count());
}

bool AdaptiveAttachment::State::accepts(vtkDataArray* array, const std::string& name) {
  const std::string text = "cell array '" + name + "'";
  if (!array || name.empty())
    skipped.push_back({text, array ? "has no name" : "holds no numbers"});
  else if (array->GetNumberOfComponents() < 1)
    skipped.push_back({text, "has no components"});
  else if (!options.convert && reason_to_convert(array))
    skipped.push_back({text, reason_to_convert(array)});
  else
    return true;
  return false;
}

/// The cell arrays that every piece has, one a piece.
std::map<std::string, std::vector<vtkDataArray*>>
AdaptiveAttachment::State::collect(vtkDataObject* data) {
  std::vector<vtkDataSetAttributes*> pieces;
  if (cells.are_leaves)
    pieces.push_back(vtkHyperTreeGrid::SafeDownCast(data)->GetCellData());
  for (const AdaptivePatch& p : cells.patches)
    pieces.push_back(p.grid->GetCellData());
  std::map<std::string, std::vector<vtkDataArray*>> out;
  for (int i = 0; !pieces.empty() && i < pieces[0]->GetNumberOfArrays(); ++i) {
    vtkAbstractArray* const any = pieces[0]->GetAbstractArray(i);
    const std::string name = any->GetName() ? any->GetName() : "";
    const auto& wanted = options.arrays;
    if (name == vtkDataSetAttributes::GhostArrayName() ||
        (!wanted.empty() && std::find(wanted.begin(), wanted.end(), name) == wanted.end()) ||
        !accepts(vtkDataArray::SafeDownCast(any), name))
      continue;
    std::vector<vtkDataArray*> arrays;
    for (vtkDataSetAttributes* piece : pieces) {
      vtkDataArray* const array = piece->GetArray(name.c_str());
      if (array && array->GetNumberOfComponents() ==
                       vtkDataArray::SafeDownCast(any)->GetNumberOfComponents())
        arrays.push_back(array);
    }
    if (arrays.size() == pieces.size())
      out.emplace(name, std::move(arrays));
    else
      skipped.push_back({"cell array '" + name + "'", std::to_string(arrays.size()) + " of " +
                                                          std::to_string(pieces.size()) +
                                                          " grids have it alike"});
  }
  for (const AdaptivePatch& p : cells.patches)
    if (p.grid->GetPointData()->GetNumberOfArrays() > 0) {
      skipped.push_back({"point arrays", "an adaptive mesh has values of cells"});
      break;
    }
  return out;
}

bool AdaptiveAttachment::State::give(const std::string& name,
                                     const std::vector<vtkDataArray*>& arrays, bool elsewhere) {
  Pieces& pieces = given[name];
  pieces.resize(arrays.size());
  bool changed = false;
  for (std::size_t p = 0; p < arrays.size(); ++p) {
    const Watched source(arrays[p]);
    if (!elsewhere && pieces[p].source.array && same(pieces[p].source, source))
      continue;
    Given next{source, adopt(arrays[p]), {}};
    std::vector<Array> out;
    next.places.resize(next.adopted.arrays.size());
    for (std::size_t c = 0; c < next.adopted.arrays.size(); ++c) {
      const Array& a = next.adopted.arrays[c];
      out.push_back(
          cells.are_leaves ? at_leaves(a, cells.leaves, next.adopted.reason, next.places[c])
          : cells.patches[p].is_whole() ? a
                                        : part_of(a, cells.patches[p], next.adopted.reason));
    }
    mesh.piece(static_cast<int>(p)).field(name, Association::cell, out);
    pieces[p] = std::move(next);
    changed = true;
  }
  for (const Given& piece : pieces)
    if (piece.adopted.reason) {
      converted.push_back({"cell array '" + name + "'", piece.adopted.reason});
      break;
    }
  return changed;
}

bool AdaptiveAttachment::State::remove_others(
    const std::map<std::string, std::vector<vtkDataArray*>>& now) {
  bool changed = false;
  for (auto it = given.begin(); it != given.end();)
    if (now.find(it->first) != now.end()) {
      ++it;
    } else {
      mesh.remove_field(it->first);
      it = given.erase(it);
      changed = true;
    }
  return changed;
}

Change AdaptiveAttachment::State::update(vtkDataObject* data) {
  AdaptiveCells next = cells_of(data); // refuses before the mesh is touched
  const bool anew = !attached || !same(cells, next);
  const bool elsewhere = anew || cells.leaves.nodes != next.leaves.nodes;
  skipped = next.notes;
  const char* const next_made_ghosts = next.made_ghosts;
  converted.clear();
  if (anew) {
    give_cells(std::move(next));
  } else {
    cells.leaves.nodes = std::move(next.leaves.nodes);
    cells.patches = std::move(next.patches);
  }
  attached = true;
  if (next_made_ghosts)
    converted.push_back({"cell array 'vtkGhostType'", next_made_ghosts});
  if (cells.are_leaves)
    converted.push_back({"levels and corners", "hyper trees keep no corners of leaves"});
  const auto now = collect(data);
  bool changed = remove_others(now);
  for (const auto& [name, arrays] : now)
    changed = give(name, arrays, elsewhere) || changed;
  return anew ? everything : changed ? insitu::fields : Change{};
}

AdaptiveAttachment::AdaptiveAttachment(std::unique_ptr<State> state) : state_(std::move(state)) {}
AdaptiveAttachment::AdaptiveAttachment(AdaptiveAttachment&&) noexcept = default;
AdaptiveAttachment& AdaptiveAttachment::operator=(AdaptiveAttachment&&) noexcept = default;
AdaptiveAttachment::~AdaptiveAttachment() = default;

Change AdaptiveAttachment::update(vtkDataObject* data) {
  return state_->update(data);
}
const std::vector<Note>& AdaptiveAttachment::converted() const {
  return state_->converted;
}
const std::vector<Note>& AdaptiveAttachment::skipped() const {
  return state_->skipped;
}

AdaptiveAttachment attach_adaptive(Mesh& mesh, vtkDataObject* data, const AttachOptions& options) {
  if (options.piece != 0)
    throw Error(INSITU_ERROR_ARGUMENT, "piece: " + std::to_string(options.piece) +
                                           "; an adaptive data object is a whole mesh");
  auto state = std::make_unique<AdaptiveAttachment::State>(mesh, options);
  state->update(data);
  return AdaptiveAttachment(std::move(state));
}

} // namespace insitu::vtk
