#pragma once

#include <cstdint>

#include "commit/committed_mesh.h"

namespace insitu::scene {

/// A cell of the own view of a mesh (mesh.mesh().own_view()) in the numbering of the solver; all
/// members are -1 outside.
struct OwnCell {
  std::int32_t piece = -1;
  std::int64_t cell = -1;
  std::int64_t flat = -1; ///< id counted through the pieces, which tables without pieces name
};
OwnCell own_cell(const mesh::MeshView& mesh, std::int64_t flat);
/// Returns the OwnCell of a cell of mesh.mesh().view() that holds the point.
OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at);

/// Returns whether files name pieces beside cells: they do where a mesh has several pieces, and on
/// adaptive meshes, whose patches come and go, always. A table that grows keeps the answer of the
/// time when it was opened.
bool names_pieces(const mesh::Mesh& mesh);

} // namespace insitu::scene
