#pragma once

#include <cstdint>

#include "commit/committed_mesh.h"

namespace insitu::scene {

/// A flat cell id of mesh.mesh().own_view() in the solver's numbering; -1 outside.
struct OwnCell {
  std::int32_t piece = -1;
  std::int64_t cell = -1;
  std::int64_t flat = -1; ///< counted through the pieces: what tables without pieces name
};
OwnCell own_cell(const mesh::MeshView& mesh, std::int64_t flat);
/// The same of a cell of mesh.mesh().view() that holds the point.
OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at);

/// Whether files name pieces beside cells: where there are several, and of adaptive meshes, whose
/// patches come and go, always. A table that grows keeps the answer of when it was opened.
bool names_pieces(const mesh::Mesh& mesh);

} // namespace insitu::scene
