#pragma once

#include "accel/faces/mesh_faces.h"
#include "core/memory.h"
#include "mesh/view.h"

namespace insitu::render {

/// Whether the cells are leaves of an adaptive mesh as they are (mesh::CellLayout::leaves).
inline bool has_leaf_faces(const mesh::MeshView& mesh) {
  return mesh.piece_count > 0 && mesh.pieces[0].layout == mesh::CellLayout::leaves;
}

/// Removes, of the faces of leaves, those inside the mesh: a face that lies in one of a leaf of the
/// same depth or a coarser one on its other side, and a face that those of finer leaves cover. What
/// finer leaves cover in part stays whole. faces: of all leaves.
void remove_faces_inside(const mesh::MeshView& mesh,
                         core::CountedVector<accel::MeshFaces::Face>& faces);

} // namespace insitu::render
