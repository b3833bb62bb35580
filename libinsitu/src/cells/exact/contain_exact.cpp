#include "cells/exact/contain_exact.h"

#include <cmath>

#include "cells/kernels/contain_query.h"
#include "math/predicates_exact.h"

namespace insitu::cells {
namespace {

using math::Vec3d;

bool is_finite(const Vec3d& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

template <mesh::Shape S>
ExactResult contain(const Vec3d* vertices, const Vec3d& point) {
  const FilterResult filtered = contain_filter<S>(vertices, point);
  if (filtered == FilterResult::inside)
    return {Containment::inside, -1, false};
  if (filtered == FilterResult::outside)
    return {Containment::outside, -1, false};
  static constexpr FaceTable table = face_table(S);
  bool finite = is_finite(point);
  for (int i = 0; i < table.vertex_count; ++i)
    finite = finite && is_finite(vertices[i]);
  if (!finite)
    return {};
  return ContainQuery<math::Predicates>(table, vertices, point).answer();
}

} // namespace

ExactResult contain_exact(mesh::Shape shape, const Vec3d* vertices, Vec3d point) {
  switch (shape) {
  case mesh::Shape::tetrahedron:
    return contain<mesh::Shape::tetrahedron>(vertices, point);
  case mesh::Shape::voxel:
    return contain<mesh::Shape::voxel>(vertices, point);
  case mesh::Shape::hexahedron:
    return contain<mesh::Shape::hexahedron>(vertices, point);
  case mesh::Shape::wedge:
    return contain<mesh::Shape::wedge>(vertices, point);
  case mesh::Shape::pyramid:
    return contain<mesh::Shape::pyramid>(vertices, point);
  case mesh::Shape::none:
    break;
  }
  return {};
}

} // namespace insitu::cells
