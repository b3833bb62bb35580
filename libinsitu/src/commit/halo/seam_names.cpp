#include "commit/halo/seam_names.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "commit/committed_mesh.h"

namespace insitu::commit {

namespace {

std::string told(const CellName& cell) {
  return "process " + std::to_string(cell.rank) + ", piece " + std::to_string(cell.piece) +
         ", cell " + std::to_string(cell.cell);
}

/// Cells of the halo whose global id a cell of this process has, too.
CellPairs cells_of_one_id(const CommittedMesh& mesh) {
  CellPairs found;
  const mesh::Mesh& own = mesh.mesh();
  if (!mesh.halo() || !own.has_global_ids(INSITU_CELL))
    return found;
  const mesh::MeshView& view = own.own_view();
  std::vector<std::pair<std::int64_t, std::int64_t>> ids; // of cells that own points; flat
  ids.reserve(std::size_t(view.own_cell_count()));
  for (std::int32_t p = 0; p < view.piece_count - view.halo_piece_count; ++p)
    for (std::int64_t c = 0; c < view.pieces[p].cell_count; ++c)
      if (view.pieces[p].owns(c))
        ids.emplace_back(own.global_id(INSITU_CELL, view.first_cell[p] + c),
                         view.first_cell[p] + c);
  if (!std::ranges::is_sorted(ids))
    std::ranges::sort(ids);
  const std::int32_t first = view.piece_count - view.halo_piece_count;
  CellName last; // of polyhedra, parts follow each other
  for (std::int32_t p = 0; p < view.halo_piece_count; ++p)
    for (std::int64_t c = 0; c < view.pieces[first + p].cell_count; ++c) {
      CellName name = mesh.halo()->name(std::size_t(p), c);
      name.copy = 0;
      const auto at = std::ranges::lower_bound(ids, std::pair(name.global, std::int64_t(-1)));
      if (name.global < 0 || at == ids.end() || at->first != name.global || name == last)
        continue;
      found.add(mesh.name(at->second), name);
      last = name;
    }
  return found;
}

} // namespace

std::string describe(const CellPairs& found, const std::string& what, const std::string& so,
                     parallel::World& world) {
  std::int64_t count = found.count;
  world.reduce(std::span(&count, 1), parallel::Reduction::sum);
  if (count == 0)
    return {};
  std::int64_t first = found.count > 0 ? world.rank() : world.size();
  world.reduce(std::span(&first, 1), parallel::Reduction::least);
  return std::to_string(count) + what + ", the first of " +
         world.broadcast(told(found.own) + " and " + told(found.other), int(first)) + so;
}

std::string describe_wrong_ids(const CommittedMesh& mesh, parallel::World& world) {
  CellPairs same;
  const std::int64_t none = world.size();
  std::int64_t with_and_without[] = {none, none}; // the first such processes
  world.agree_after([&] {
    same = cells_of_one_id(mesh);
    if (mesh.mesh().own_view().own_cell_count() > 0)
      with_and_without[mesh.mesh().has_global_ids(INSITU_CELL) ? 0 : 1] = world.rank();
  });
  world.reduce(std::span(with_and_without), parallel::Reduction::least);
  std::string text =
      describe(same, " cells have the global id of another process's cell beside them",
               ": a process's own numbers are no global ids; who owns a point "
               "between such cells hangs on how they are spread",
               world);
  const auto [with, without] = with_and_without;
  if (with != none && without != none)
    text += std::string(text.empty() ? "" : "; ") + "process " + std::to_string(with) +
            " gives global ids of cells and process " + std::to_string(without) +
            " gives none: who owns a point between their cells hangs on how they are spread";
  return text;
}

} // namespace insitu::commit
