#pragma once

#include <cstdint>

#include "accel/locator.h"

namespace insitu::accel {

/// A triangle that rays of the face methods hit, with the cells on its sides (Morrical 2020,
/// figures 5, 7 and 12). Its normal is (v1 - v0) x (v2 - v0). A ray that starts on the side into
/// which the normal points hits the front.
///
/// Vertices are flat ids (mesh::MeshView), and the array of triangles is an index buffer with a
/// stride: Embree and OptiX read the first three numbers.
struct FaceTriangle {
  std::uint32_t vertices[3];
  /// The fourth corner of a curved quad, in the cycle v0, v1, v2, corner: the triangle is then a
  /// face of the quad's corner tetrahedron, its normal points out of that, and v0-v2 is its
  /// diagonal. `none`: the triangle is the face, or half of a planar one.
  std::uint32_t corner;
  /// Cells on the front's and the back's side, or `none`. Of a curved quad: the cells beyond the
  /// patch on the triangle's side, and on the other. Replicated faces: the cell is in front,
  /// nothing behind.
  std::uint32_t front, back;
};
static_assert(sizeof(FaceTriangle) == 24);

} // namespace insitu::accel
