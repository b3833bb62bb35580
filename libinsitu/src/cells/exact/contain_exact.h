#pragma once

#include <cstdint>

#include "math/vec.h"
#include "mesh/shape.h"

/// Whether a point lies in a cell: the exact answer, for linear cells and cells with bilinear
/// faces.
///
/// The cell's boundary is its triangles and, for each quad, the bilinear patch of its four corners.
/// The closed cell is that boundary and every point from which a ray that meets the boundary
/// nowhere tangentially crosses it an odd number of times. So the answer depends on the boundary
/// alone: not on orientation, on the order of a face's vertices, or on the direction of any ray,
/// and neighbours that share a face agree on which side of it a point is. The answer is exact for
/// the doubles given, as if computed in real arithmetic, over the whole range of finite doubles,
/// subnormal and near overflow included.
///
/// Cells that are not as they should be have an answer all the same:
///  - inverted: the same as the cell turned right.
///  - folded: a region that the boundary surrounds an even number of times is outside. On a mesh
///    that covers its domain, every point off all faces is then inside an odd number of cells.
///  - collapsed (vertices that coincide, collinear quads, no volume): the boundary that remains, as
///    above. A quad with two coincident neighbours is the triangle that is left; a cell without
///    volume has no inside, but its faces, edges and vertices still hold their points.
///  - a planar quad that is not convex: the face is the part of the plane that its four edges
///    surround an odd number of times, and the edges.
///  - a coordinate that is NaN or infinite, of the point or of any vertex: outside.
///
/// The floating-point environment must be IEEE's default (nearest, gradual underflow), as the entry
/// points of the library set it.
namespace insitu::cells {

enum class Containment : std::uint8_t { outside, inside, on_face, on_edge, on_vertex };

struct ExactResult {
  /// The lowest-dimensional part of the closed cell that holds the point; `inside` is strict.
  Containment where = Containment::outside;
  /// The local number of that face, edge or vertex in face_table(shape), the first of several;
  /// -1 for inside and outside.
  std::int8_t feature = -1;
  /// Some sign needed more than the filter in double.
  bool exact_used = false;
};

/// Whether `where` means that the closed cell holds the point.
constexpr bool holds(Containment where) {
  return where != Containment::outside;
}

/// `vertices` are vertex_count(shape) points in VTK order. Allocates nothing, never throws. Most
/// points cost one contain_filter (contain_filter.h); the rest take microseconds.
ExactResult contain_exact(mesh::Shape shape, const math::Vec3d* vertices, math::Vec3d point);

} // namespace insitu::cells
