#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>

#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "math/vec.h"

/// A cell of a dual mesh: its volume, and its faces as others meet them.
namespace insitu::test {

struct DualCell {
  mesh::Shape shape;
  int count;
  std::int64_t vertices[8]; ///< by place: equal bits, equal vertex
  math::Vec3d x[8];
  bool stitching;
  std::int64_t in_piece;
};

struct PointLess {
  bool operator()(const math::Vec3d& a, const math::Vec3d& b) const {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  }
};

/// The integral of the Jacobian: two Gauss points an axis are exact for a trilinear map. Wedges and
/// pyramids have the map of the hexahedron that they are collapsed from.
inline double volume(const DualCell& c) {
  if (c.shape == mesh::Shape::tetrahedron)
    return math::dot(math::cross(c.x[1] - c.x[0], c.x[2] - c.x[0]), c.x[3] - c.x[0]) / 6.0;
  static constexpr int of_pyramid[8] = {0, 1, 2, 3, 4, 4, 4, 4};
  static constexpr int of_wedge[8] = {0, 2, 1, 1, 3, 5, 4, 4}; // VTK's wedge stands on its head
  math::Vec3d x[8];
  for (int v = 0; v < 8; ++v)
    x[v] = c.x[c.shape == mesh::Shape::pyramid ? of_pyramid[v]
               : c.shape == mesh::Shape::wedge ? of_wedge[v]
                                               : v];
  const mesh::Shape shape =
      c.shape == mesh::Shape::voxel ? mesh::Shape::voxel : mesh::Shape::hexahedron;
  double sum = 0.0;
  for (int g = 0; g < 8; ++g) {
    const double h = 0.5 / std::sqrt(3.0);
    math::Vec3d j[3];
    cells::jacobian(
        shape, x,
        math::Vec3d{0.5 + (g & 1 ? h : -h), 0.5 + (g & 2 ? h : -h), 0.5 + (g & 4 ? h : -h)}, j);
    sum += math::dot(j[0], math::cross(j[1], j[2])) / 8.0;
  }
  return sum;
}

/// A face by its vertices in cyclic order from the lowest on, and towards its lower neighbour.
struct FaceKey {
  int count = 0;
  std::int64_t v[4] = {-1, -1, -1, -1};
  auto operator<=>(const FaceKey&) const = default;
};
struct FaceUse {
  int count = 0, turn = 0;
  math::Vec3d x[4];
};

/// Returns +1 or -1, the turn that was taken; 0: the face is an edge or a point.
inline int face_key(const DualCell& c, const cells::Face& f, FaceKey& key, math::Vec3d* x) {
  std::int64_t v[4];
  math::Vec3d p[4];
  int n = 0;
  for (int i = 0; i < f.vertex_count; ++i) {
    const std::int64_t id = c.vertices[f.vertices[i]];
    if (n > 0 && (v[n - 1] == id || (i + 1 == f.vertex_count && v[0] == id)))
      continue;
    p[n] = c.x[f.vertices[i]];
    v[n++] = id;
  }
  if (n < 3)
    return 0;
  const int low = int(std::min_element(v, v + n) - v);
  const int turn = v[(low + 1) % n] < v[(low + n - 1) % n] ? 1 : -1;
  key.count = n;
  for (int i = 0; i < n; ++i) {
    const int from = (low + turn * i + n) % n;
    key.v[i] = v[from];
    x[i] = p[from];
  }
  return turn;
}

/// The flux of x/3 through a bilinear face: the mean over its two pairs of triangles.
inline double flux(const math::Vec3d* x, int count) {
  const auto triple = [&](int i, int j, int k) {
    return math::dot(x[i], math::cross(x[j], x[k])) / 6.0;
  };
  return count == 3 ? triple(0, 1, 2)
                    : 0.5 * (triple(0, 1, 2) + triple(0, 2, 3) + triple(0, 1, 3) + triple(1, 2, 3));
}

} // namespace insitu::test
