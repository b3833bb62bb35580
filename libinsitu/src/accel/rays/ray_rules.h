#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "accel/faces/face_triangle.h"
#include "math/hd.h"
#include "math/vec.h"

/// What the ray methods decide, once for every home: Embree's callbacks, OptiX's programs and plain
/// tests call these; a backend brings traversal and memory.
namespace insitu::accel {

/// The ray that finds the cell of a point, in the tree's local frame.
struct PointRay {
  math::Vec3f origin, direction; ///< the direction has length 1
  float length;
};

/// A direction that differs from point to point and depends on nothing else, so that rays along
/// edges stay rare whatever the mesh, and answers depend on neither order nor threads (Morrical
/// 2020, section 8, draws it at random).
INSITU_HD inline math::Vec3f ray_direction(const math::Vec3d& p) {
  std::uint64_t h = 0;
  for (int a = 0; a < 3; ++a) {
    h = (h ^ std::bit_cast<std::uint64_t>(p[a])) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 31;
  }
  h *= 0xbf58476d1ce4e5b9ull;
  h ^= h >> 29;
  const auto part = [h](int shift) { return float((h >> shift) & 0xfffff) * 0x1p-19f - 1.0f; };
  const math::Vec3f d{part(0), part(20), part(40)};
  const float square = d.x * d.x + d.y * d.y + d.z * d.z;
  if (!(square > 1e-4f))
    return {0.57735027f, 0.57735027f, 0.57735027f};
  const float scale = 1.0f / std::sqrt(square);
  return {d.x * scale, d.y * scale, d.z * scale};
}

/// length: of every ray of the mesh, the largest distance of two vertices of a cell, rounded up;
/// for `user_geometry` a vanishing one.
INSITU_HD inline PointRay point_ray(const math::Vec3d& p, const math::Vec3d& frame_origin,
                                    float length) {
  const math::Vec3d d = p - frame_origin;
  return {{float(d.x), float(d.y), float(d.z)}, ray_direction(p), length};
}

/// Whether the point lies in the corner tetrahedron of quad v0, v1, v2, v3, and there on the side
/// of the bilinear patch where the diagonal v0-v2 is, a c > b d (doc/design/locate.md): what
/// cell_of_hit asks. The tetrahedron is asked for as well, since rounding may make it flat: then a
/// ray from afar hits its back, and the products say nothing. T: float, or double.
template <class T>
INSITU_HD inline bool is_beside(const math::Vec3<T>* v, const math::Vec3<T>& p) {
  const math::Vec3<T> r0 = v[0] - p, r1 = v[1] - p, r2 = v[2] - p, r3 = v[3] - p;
  const math::Vec3<T> n0 = cross(r0, r1), n1 = cross(r2, r3);
  const T a = -dot(r1, n1), b = dot(r0, n1), c = -dot(r3, n0), d = dot(r2, n0);
  const T zero(0);
  const bool in_tetrahedron = (a > zero && b > zero && c > zero && d > zero) ||
                              (a < zero && b < zero && c < zero && d < zero);
  return in_tetrahedron && a * c > b * d;
}

/// The cell that the closest hit tells, or `none`: the papers' rule (Morrical 2020, sections 6.2
/// and 7.1), with the side of the patch asked for instead of a ray's crossing, which it may do
/// twice. beside(triangle): whether the point lies between the triangle and its quad's patch; asked
/// at most once.
template <class Beside>
INSITU_HD inline std::uint32_t cell_of_hit(const FaceTriangle& triangle, bool hit_back,
                                           Beside&& beside) {
  if (!hit_back)
    return triangle.front;
  if (triangle.corner == none)
    return triangle.back;
  return beside(triangle) ? triangle.front : triangle.back; // inside the corner tetrahedron
}

} // namespace insitu::accel
