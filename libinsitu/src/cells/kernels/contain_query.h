#pragma once

#include "cells/exact/contain_exact.h"
#include "cells/kernels/contain_filter.h"
#include "cells/kernels/faces.h"
#include "math/predicates.h"

/// The test behind contain_exact, over predicates that decide all (the host's), or as much as
/// double-double tells (a device's, which leaves the rest).
namespace insitu::cells {

using math::Vec3d;

/// Exact questions about one point and the vertices of one cell.
///
/// `perturbed_*` ask them of the point moved by (e1, e2, e3) with 1 >> e1 >> e2 >> e3 > 0
/// (Edelsbrunner and Muecke 1990, "Simulation of simplicity"). A point off the boundary has a whole
/// neighbourhood on its side of it, so the moved point has the same answer; and it lies on no
/// diagonal triangle, and its +x ray meets no edge.
template <class Predicates>
class ContainQuery {
public:
  INSITU_HD ContainQuery(const FaceTable& table, const Vec3d* vertices, const Vec3d& point)
      : table_(table), vertices_(vertices), point_(point) {
    for (int i = 0; i < table.vertex_count; ++i) {
      sides_[i] = detail::sides(vertices[i] - point);
    }
  }

  INSITU_HD ExactResult answer();
  INSITU_HD const Predicates& predicates() const { return predicates_; }

private:
  /// Turn of i -> j around the point, seen along an axis.
  INSITU_HD int turn(int i, int j, int axis) {
    const int u = (axis + 1) % 3, w = (axis + 2) % 3;
    const Vec3d &a = vertices_[i], &b = vertices_[j];
    return predicates_.orient2d(a[u], a[w], b[u], b[w], point_[u], point_[w]);
  }
  /// A component of the normal of a triangle.
  INSITU_HD int normal(int i, int j, int k, int axis) {
    const int u = (axis + 1) % 3, w = (axis + 2) % 3;
    const Vec3d &a = vertices_[i], &b = vertices_[j], &c = vertices_[k];
    return predicates_.orient2d(a[u], a[w], b[u], b[w], c[u], c[w]);
  }
  INSITU_HD int volume(int i, int j, int k) {
    return predicates_.orient3d(vertices_[i], vertices_[j], vertices_[k], point_);
  }
  INSITU_HD int perturbed_turn(int i, int j);
  INSITU_HD int perturbed_volume(int known, int i, int j, int k);

  /// Every edge, triangle and patch lies in the box of its vertices.
  INSITU_HD bool in_box(const std::uint8_t* v, int count) const {
    return shared_sides(v, count) == 0;
  }
  INSITU_HD unsigned shared_sides(const std::uint8_t* v, int count) const {
    unsigned shared = ~0u;
    for (int i = 0; i < count; ++i)
      shared &= sides_[v[i]];
    return shared;
  }

  INSITU_HD bool on_segment(const Edge& edge);
  INSITU_HD bool in_planar_polygon(const std::uint8_t* v, int count);
  INSITU_HD bool ray_crosses(int i, int j, int k, bool in_front);
  /// The point is on the face's interior; else `crossings` counts the moved point's ray.
  INSITU_HD bool on_triangle(const Face& face, unsigned shared, int& crossings);
  INSITU_HD bool on_quad(const Face& face, unsigned shared, int& crossings);

  INSITU_HD ExactResult result(Containment where, int feature) const {
    return {where, static_cast<std::int8_t>(feature), predicates_.deepest != math::Stage::filter};
  }

  const FaceTable& table_;
  const Vec3d* vertices_;
  Vec3d point_;
  unsigned sides_[8] = {};
  Predicates predicates_;
};

/// The moved point's minor is e - e2 (z_j - z_i) + e3 (y_j - y_i); zero for no extent in y and z.
template <class Predicates>
INSITU_HD int ContainQuery<Predicates>::perturbed_turn(int i, int j) {
  const int sign = turn(i, j, 0);
  if (sign != 0)
    return sign;
  const Vec3d &a = vertices_[i], &b = vertices_[j];
  if (a.z != b.z)
    return b.z < a.z ? 1 : -1;
  if (a.y != b.y)
    return b.y > a.y ? 1 : -1;
  return 0;
}

/// The moved point's volume is the known one minus (e1, e2, e3) . normal.
template <class Predicates>
INSITU_HD int ContainQuery<Predicates>::perturbed_volume(int known, int i, int j, int k) {
  if (known != 0)
    return known;
  for (int axis = 0; axis < 3; ++axis) {
    const int sign = normal(i, j, k, axis);
    if (sign != 0)
      return -sign;
  }
  return 0;
}

template <class Predicates>
INSITU_HD bool ContainQuery<Predicates>::on_segment(const Edge& edge) {
  const int i = edge.vertices[0], j = edge.vertices[1];
  return in_box(edge.vertices, 2) && turn(i, j, 0) == 0 && turn(i, j, 1) == 0 && turn(i, j, 2) == 0;
}

/// For a polygon whose plane holds the point, none of whose edges does: even-odd rule in a
/// projection that keeps the plane a plane. A polygon without area holds nothing.
template <class Predicates>
INSITU_HD bool ContainQuery<Predicates>::in_planar_polygon(const std::uint8_t* v, int count) {
  int axis = 0;
  while (axis < 3 && normal(v[0], v[1], v[2], axis) == 0 &&
         (count == 3 || normal(v[0], v[2], v[3], axis) == 0)) {
    ++axis;
  }
  if (axis == 3)
    return false;
  const int w = (axis + 2) % 3;
  bool inside = false;
  for (int e = 0; e < count; ++e) {
    const int i = v[e], j = v[(e + 1) % count];
    const bool i_above = vertices_[i][w] > point_[w], j_above = vertices_[j][w] > point_[w];
    if (i_above != j_above)
      inside ^= (turn(i, j, axis) > 0) == j_above;
  }
  return inside;
}

template <class Predicates>
INSITU_HD bool ContainQuery<Predicates>::ray_crosses(int i, int j, int k, bool in_front) {
  const int sign = perturbed_turn(i, j);
  if (sign == 0 || perturbed_turn(j, k) != sign || perturbed_turn(k, i) != sign)
    return false;
  // A point on the triangle moves by e1, past it: volume 0 is no crossing.
  return in_front || volume(i, j, k) == sign;
}

template <class Predicates>
INSITU_HD bool ContainQuery<Predicates>::on_triangle(const Face& face, unsigned shared,
                                                     int& crossings) {
  const auto& v = face.vertices;
  if (shared == 0 && volume(v[0], v[1], v[2]) == 0 && in_planar_polygon(v, 3))
    return true;
  crossings += ray_crosses(v[0], v[1], v[2], (shared & detail::front) != 0);
  return false;
}

template <class Predicates>
INSITU_HD bool ContainQuery<Predicates>::on_quad(const Face& face, unsigned shared,
                                                 int& crossings) {
  const Quad quad = canonical_order(face, vertices_);
  const auto& v = quad.vertices;
  const bool in_front = (shared & detail::front) != 0;
  if (shared == 0) {
    const int a = -volume(v[1], v[2], v[3]), b = volume(v[0], v[2], v[3]);
    const int c = -volume(v[0], v[1], v[3]), d = volume(v[0], v[1], v[2]);
    if (a == 0 && b == 0 && c == 0 && d == 0) { // planar, and the point is in the plane
      if (in_planar_polygon(v, 4))
        return true;
    } else if ((a >= 0 && b >= 0 && c >= 0 && d >= 0) || (a <= 0 && b <= 0 && c <= 0 && d <= 0)) {
      const int side = predicates_.bilinear_side(vertices_[v[0]], vertices_[v[1]], vertices_[v[2]],
                                                 vertices_[v[3]], point_);
      if (side == 0)
        return true;
      // Between the patch and its triangles, where a and c are not 0 (a c > b d >= 0). The point
      // may lie on a triangle; the moved point is in the tetrahedron or not.
      if (side > 0 && perturbed_volume(b, v[0], v[2], v[3]) == a &&
          perturbed_volume(d, v[0], v[1], v[2]) == a) {
        ++crossings;
      }
    }
  }
  crossings += ray_crosses(v[0], v[1], v[2], in_front);
  crossings += ray_crosses(v[0], v[2], v[3], in_front);
  return false;
}

template <class Predicates>
INSITU_HD ExactResult ContainQuery<Predicates>::answer() {
  for (int i = 0; i < table_.vertex_count; ++i) {
    if (vertices_[i] == point_)
      return result(Containment::on_vertex, i);
  }
  for (int i = 0; i < table_.edge_count; ++i) {
    if (on_segment(table_.edges[i]))
      return result(Containment::on_edge, i);
  }
  int crossings = 0;
  for (int i = 0; i < table_.face_count; ++i) {
    const Face& face = table_.faces[i];
    const unsigned shared = shared_sides(face.vertices, face.vertex_count);
    if ((shared & (detail::beside | detail::behind)) != 0)
      continue;
    if (face.vertex_count == 3 ? on_triangle(face, shared, crossings)
                               : on_quad(face, shared, crossings)) {
      return result(Containment::on_face, i);
    }
  }
  return result(crossings % 2 != 0 ? Containment::inside : Containment::outside, -1);
}

} // namespace insitu::cells
