#pragma once

#include "accel/faces/mesh_faces.h"
#include "accel/tree/tree.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::commit {

/// Whether a search finds no two cells that share interior (MeshView::covers_once): one piece, free
/// of folds, neighbours on either side of every face that they share, and no vertex of a boundary
/// face in or on a cell that does not have it. Vertices are told apart by ids, so parts that touch
/// without sharing vertices are taken to overlap. Not found: boundaries that cross with no vertex
/// of either inside the other. faces, tree: of this mesh. Costs locating the boundary's vertices.
bool covers_once(const mesh::MeshView& mesh, const accel::MeshFaces& faces, const accel::Tree& tree,
                 const core::Threads& threads);

/// Whether a search finds no cell of one piece that shares interior with another piece's: no middle
/// of an owning cell in or on another piece's cell, and no vertex in or on one that has no vertex
/// of the same coordinates. Pieces whose boxes share no interior need no search. Not found: pieces
/// that cross with no vertex of either inside the other. tree: of this mesh.
bool pieces_are_apart(const mesh::MeshView& mesh, const accel::Tree& tree,
                      const core::Threads& threads);

} // namespace insitu::commit
