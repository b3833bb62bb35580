#include "scene/checkpoint/kept_cells.h"

namespace insitu::scene {

KeptCells::KeptCells(By by, const commit::CommittedMesh& mesh, int rank)
    : by_(by), mesh_(mesh), rank_(rank) {
  if (by == By::ids)
    ids_.emplace(mesh);
}

std::int64_t KeptCells::find(const mesh::CellName& name) const {
  if (ids_)
    return ids_->find(name);
  if (by_ == By::nothing || name.rank != rank_)
    return -1;
  const mesh::MeshView& view = mesh_.mesh().view();
  const bool is_here = name.piece >= 0 && name.piece < view.piece_count - view.halo_piece_count &&
                       name.cell >= 0 && name.cell < view.pieces[name.piece].cell_count;
  return is_here ? view.first_cell[name.piece] + name.cell : -1;
}

mesh::CellName kept_name(const commit::CommittedMesh& mesh, std::int64_t flat, int rank) {
  const mesh::MeshView& view = mesh.mesh().view();
  if (flat < 0 || flat >= view.cell_count())
    return {};
  const commit::StandIn* const stand_in = mesh.stand_in();
  const bool is_made = stand_in && stand_in->is_made();
  if (flat >= view.own_cell_count())
    return is_made ? mesh.name(flat) : mesh.located_name(flat); // of the halo
  const std::int32_t piece = view.piece_of(flat);
  mesh::CellName name{-1, rank, piece, flat - view.first_cell[piece]};
  if (is_made)
    return name;
  const commit::StandIn::Place at = stand_in ? stand_in->place(flat) : commit::StandIn::Place{flat};
  name.global = mesh.mesh().global_id(INSITU_CELL, at.own);
  name.chart = at.chart;
  name.copy = at.copy;
  return name;
}

bool names_cells(const commit::CommittedMesh& mesh, const parallel::World& world) {
  return world.size() > 1 || commit::are_known_by_ids(mesh);
}

} // namespace insitu::scene
