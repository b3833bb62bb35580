#include "scene/run/own_cell.h"

namespace insitu::scene {

bool names_pieces(const mesh::Mesh& mesh) {
  return mesh.is_adaptive() || mesh.own_view().piece_count > 1;
}

OwnCell own_cell(const mesh::MeshView& mesh, std::int64_t flat) {
  if (flat < 0 || flat >= mesh.cell_count())
    return {};
  const std::int32_t piece = mesh.piece_of(flat);
  return {piece, flat - mesh.first_cell[piece], flat};
}

OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at) {
  return own_cell(mesh.mesh().own_view(), mesh.own({flat, {}}, at).cell);
}

} // namespace insitu::scene
