#pragma once

#include "mesh/view.h"

namespace insitu::mesh {

/// Whether a mesh is one piece, or as good as one (MeshView::one_mesh). The pieces of a halo are
/// cells of the same mesh, so one piece with its halo is what that mesh is to one process.
inline bool is_one(const MeshView& mesh) {
  return mesh.one_mesh || mesh.piece_count - mesh.halo_piece_count <= 1;
}

} // namespace insitu::mesh
