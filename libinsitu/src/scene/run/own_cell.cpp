#include "scene/run/own_cell.h"

#include "core/status.h"

namespace insitu::scene {

bool names_pieces(const mesh::Mesh& mesh) {
  const mesh::MeshView& view = mesh.own_view();
  return mesh.is_adaptive() || view.piece_count - view.halo_piece_count > 1;
}

OwnCell own_cell(const mesh::MeshView& mesh, std::int64_t flat) {
  if (flat < 0 || flat >= mesh.cell_count())
    return {};
  const std::int32_t piece = mesh.piece_of(flat);
  return {piece, flat - mesh.first_cell[piece], flat};
}

OwnCell own_cell(const mesh::Mesh& mesh, std::int64_t flat, const parallel::World& world) {
  OwnCell own = own_cell(mesh.own_view(), flat);
  if (own.flat < 0)
    return own;
  own.global = mesh.global_id(INSITU_CELL, flat);
  own.process = world.rank();
  own.chart = 0;
  return own;
}

OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at) {
  return own_cell(mesh.mesh().own_view(), mesh.own({flat, {}}, at).cell);
}

OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at,
                 const parallel::World& world) {
  const std::int64_t own = mesh.own({flat, {}}, at).cell;
  const mesh::MeshView& view = mesh.mesh().own_view();
  if (own < view.own_cell_count() || own >= view.cell_count())
    return own_cell(mesh.mesh(), own, world);
  const mesh::CellName name = mesh.name(own); // another process's
  return {name.piece, name.cell, name.cell, name.global, name.rank};
}

void CellNames::require_for(const std::string& path, const CellNames& now) const {
  if (global && !now.global)
    throw core::Error(INSITU_ERROR_FIELD,
                      "the table '" + path +
                          "' names cells by global ids, which the mesh does not have any more");
}

CellNames name_cells(const mesh::Mesh& mesh, parallel::World& world) {
  const bool has_cells = mesh.own_view().own_cell_count() > 0;
  std::int64_t here[] = {has_cells, has_cells && !mesh.has_global_ids(INSITU_CELL),
                         names_pieces(mesh)};
  world.reduce(here, parallel::Reduction::greatest);
  CellNames names;
  names.global = here[0] && !here[1];
  names.pieces = !names.global && here[2];
  names.processes = !names.global && world.size() > 1;
  return names;
}

} // namespace insitu::scene
