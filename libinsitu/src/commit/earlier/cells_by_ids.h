#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "commit/committed_mesh.h"
#include "mesh/registered/earlier_step.h"
#include "parallel/world.h"

/// Cells that are known by their global ids, whichever process has them, of meshes whose cells are
/// the solver's, copies or parts of these: cells here are those of CommittedMesh::mesh().view().
namespace insitu::commit {

/// Whether the cells of this process have ids: global ids, and where others stand in for the
/// solver's such as leave room for the number of a part or a copy.
bool are_known_by_ids(const CommittedMesh& mesh);
/// By which a cell is known in files, and between processes: its global id, where others stand in
/// for the solver's with the number of the polyhedron's part or the copy on a chart.
std::int64_t id_of_cell(const CommittedMesh& mesh, std::int64_t flat);

/// Finds this process's cells by their ids.
class CellsByIds {
public:
  explicit CellsByIds(const CommittedMesh& mesh);
  /// The flat id of the cell that this process owns; -1: it has none of this name.
  std::int64_t find(const CellName& name) const;

private:
  bool stand_in_;
  std::vector<std::pair<std::int64_t, std::int64_t>> cells_; ///< ascending
};

/// The ids of this process's cells, ghosts among them; none if it has no such ids.
std::vector<std::int64_t> ids_of_cells(const CommittedMesh& mesh);
/// Where these cells are of the solver's, if some are in copies on charts; else nothing.
std::vector<StandIn::Place> places_of_cells(const CommittedMesh& mesh);

/// Visits the cells of own pieces that own points: visit(flat id).
template <class Visit>
void for_each_owner(const mesh::MeshView& view, Visit&& visit) {
  for (std::int32_t p = 0; p < view.piece_count - view.halo_piece_count; ++p)
    for (std::int64_t c = 0; c < view.pieces[p].cell_count; ++c)
      if (view.pieces[p].owns(c))
        visit(view.first_cell[p] + c);
}

/// A sum over the cells that this process owns of hashes of their ids, shapes and their vertices'
/// ids, if these have some. Over all processes it wraps to the same number however cells are dealt.
std::uint64_t sum_of_cells(const CommittedMesh& mesh, const core::Threads& threads);

} // namespace insitu::commit
