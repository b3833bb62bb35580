#pragma once

#include <cstdint>

#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::cells {

/// Where neighbours do not share a face, that is the same triangle or the same cyclic quad of
/// bitwise equal vertices (ids do not matter). Points there have an answer all the same, cell by
/// cell: the lowest id of the cells that hold them, or none in a gap.
struct Conformity {
  /// Vertices at the place of another vertex, bit for bit: joints of pieces, seams. Faces are
  /// matched by place, so these alone lose and double no point.
  std::int64_t coincident_vertices = 0;
  /// Faces of three cells or more. Cells overlap there, if they have volume: the lowest id owns.
  std::int64_t crowded_faces = 0;
  /// Quads that meet two triangles, or the same corners in another cyclic order. Between the patch
  /// and the triangles both neighbours hold a point, or neither does.
  std::int64_t split_faces = 0;
};

/// Looks at the faces of all cells that can own points. Hanging vertices, on a neighbour's edge or
/// face, are another search (commit/checks/hanging_vertices.h). Needs memory for the vertices'
/// order and the faces, some 40 bytes a vertex and 32 a face of a cell; takes about as long as a
/// build. The mesh must be valid (validate.h).
Conformity check_conformity(const mesh::MeshView& mesh, const core::Threads& threads);

} // namespace insitu::cells
