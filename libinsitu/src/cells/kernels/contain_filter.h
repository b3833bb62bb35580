#pragma once

#include <cmath>
#include <cstdint>

#include "cells/kernels/faces.h"
#include "math/hd.h"
#include "math/predicates.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// Point in cell, as far as plain floating point can prove it: the first stage of contain_exact,
/// and the whole test on a device, which hands undecided points back to the host.
namespace insitu::cells {

enum class FilterResult : std::uint8_t { outside, inside, undecided };

/// `inside` and `outside` are proofs of strict interior and strict exterior in the sense of
/// contain_exact.h; points on or very near a face, edge or vertex are undecided, and so are points
/// whose +x ray passes very near an edge in front of them. `vertices` are in VTK order.
template <mesh::Shape S, class T>
INSITU_HD FilterResult contain_filter(const math::Vec3<T>* vertices, const math::Vec3<T>& point);

// Implementation

namespace detail {

/// Where a vertex lies from the point, one bit per half space, strictly and without rounding (the
/// sign of a floating-point difference is exact).
enum Side : unsigned {
  front = 1u, // x above: ahead on the ray
  behind = 2u,
  beside = 4u + 8u + 16u + 32u, // y above, y below, z above, z below
};

template <class T>
INSITU_HD inline unsigned sides(const math::Vec3<T>& r) {
  return unsigned(r.x > 0) | unsigned(r.x < 0) << 1 | unsigned(r.y > 0) << 2 |
         unsigned(r.y < 0) << 3 | unsigned(r.z > 0) << 4 | unsigned(r.z < 0) << 5;
}

/// Bounds on the rounding of every 2x2 minor in y, z and every 3x3 determinant of vertices relative
/// to the point.
template <class T>
struct FilterBounds {
  T minor, determinant;
};

/// -1, 1: the projections of three vectors turn around the origin that way, all three by more than
/// the bound. 0: proven not to surround it. Else undecided.
template <class T>
INSITU_HD inline int surrounds(T e0, T e1, T e2, T bound) {
  const T low = e0 < e1 ? (e0 < e2 ? e0 : e2) : (e1 < e2 ? e1 : e2);
  const T high = e0 > e1 ? (e0 > e2 ? e0 : e2) : (e1 > e2 ? e1 : e2);
  if (low > bound)
    return 1;
  if (high < -bound)
    return -1;
  return high > bound && low < -bound ? 0 : math::undecided;
}

/// Crossings of the ray with a triangle (0 or 1), or undecided. `turn` is surrounds() of it.
template <class T>
INSITU_HD inline int crossings(int turn, bool in_front, T determinant, T bound) {
  if (turn == math::undecided || turn == 0)
    return turn;
  if (in_front)
    return 1;
  const int sign = math::certified_sign(determinant, bound);
  return sign == math::undecided ? sign : int(sign == turn);
}

template <class T>
INSITU_HD inline T minor(const math::Vec3<T>& a, const math::Vec3<T>& b) {
  return a.y * b.z - a.z * b.y;
}

template <class T>
INSITU_HD inline int triangle_crossings(const math::Vec3<T>& a, const math::Vec3<T>& b,
                                        const math::Vec3<T>& c, bool in_front,
                                        const FilterBounds<T>& bounds) {
  const int turn = surrounds(minor(a, b), minor(b, c), minor(c, a), bounds.minor);
  const T determinant = in_front || turn == 0 ? T(0) : dot(a, cross(b, c));
  return crossings(turn, in_front, determinant, bounds.determinant);
}

/// Crossings of the ray with the patch, modulo two, or undecided.
template <class T>
INSITU_HD inline int patch_crossings(const math::Vec3<T>& r00, const math::Vec3<T>& r10,
                                     const math::Vec3<T>& r11, const math::Vec3<T>& r01,
                                     bool in_front, const FilterBounds<T>& bounds) {
  const T e0 = minor(r00, r10), e1 = minor(r10, r11), e2 = minor(r11, r01), e3 = minor(r01, r00);
  if (in_front) {
    // Four turns of the same sign, each below half a circle, make one full circle: the ray passes
    // through the patch an odd number of times, and the diagonal need not be looked at. (It is
    // where the rays of cell centres go.)
    const T bound = bounds.minor;
    if (e0 > bound && e1 > bound && e2 > bound && e3 > bound)
      return 1;
    if (e0 < -bound && e1 < -bound && e2 < -bound && e3 < -bound)
      return 1;
  }
  const T diagonal = minor(r00, r11);
  const int turn_first = surrounds(e0, e1, -diagonal, bounds.minor);
  const int turn_second = surrounds(diagonal, e2, e3, bounds.minor);
  if (in_front) {
    const int first = crossings(turn_first, true, T(0), bounds.determinant);
    const int second = crossings(turn_second, true, T(0), bounds.determinant);
    return first == math::undecided || second == math::undecided ? math::undecided : first ^ second;
  }
  const math::Vec3<T> n0 = cross(r00, r10), n1 = cross(r11, r01);
  const T a = -dot(r10, n1), b = dot(r00, n1), c = -dot(r01, n0), d = dot(r11, n0);
  const int first = crossings(turn_first, false, d, bounds.determinant);
  const int second = crossings(turn_second, false, b, bounds.determinant);
  if (first == math::undecided || second == math::undecided)
    return math::undecided;

  const T bound = bounds.determinant;
  const bool some_positive = a > bound || b > bound || c > bound || d > bound;
  const bool some_negative = a < -bound || b < -bound || c < -bound || d < -bound;
  if (some_positive && some_negative)
    return first ^ second; // outside the corner tetrahedron
  const bool all_positive = a > bound && b > bound && c > bound && d > bound;
  const bool all_negative = a < -bound && b < -bound && c < -bound && d < -bound;
  if (!all_positive && !all_negative)
    return math::undecided;
  const int side = math::certified_sign(
      a * c - b * d,
      math::bilinear_bound(a, b, c, d, bound, 4 * math::FilterLimits<T>::unit_roundoff));
  if (side == math::undecided)
    return side;
  return first ^ second ^ int(side > 0);
}

} // namespace detail

template <mesh::Shape S, class T>
INSITU_HD FilterResult contain_filter(const math::Vec3<T>* vertices, const math::Vec3<T>& point) {
  using math::FilterLimits;
  constexpr FaceTable table = face_table(S);
  math::Vec3<T> r[table.vertex_count];
  unsigned vertex_sides[table.vertex_count];
  unsigned common = ~0u;
  for (int i = 0; i < table.vertex_count; ++i) {
    r[i] = vertices[i] - point;
    vertex_sides[i] = detail::sides(r[i]);
    common &= vertex_sides[i];
  }
  if (common != 0)
    return FilterResult::outside; // of the bounding box

  T x = 0, y = 0, z = 0;
  math::Vec3<T> sum{};
  for (int i = 0; i < table.vertex_count; ++i) {
    const math::Vec3<T> magnitude = {std::fabs(r[i].x), std::fabs(r[i].y), std::fabs(r[i].z)};
    x = magnitude.x > x ? magnitude.x : x; // skips NaN, which the sum keeps
    y = magnitude.y > y ? magnitude.y : y;
    z = magnitude.z > z ? magnitude.z : z;
    sum += magnitude;
  }
  constexpr T limit = FilterLimits<T>::max_difference;
  constexpr T sum_limit = limit * table.vertex_count;
  if (!(x <= limit && y <= limit && z <= limit && sum.x + sum.y + sum.z <= 3 * sum_limit)) {
    return FilterResult::undecided;
  }

  constexpr T u = FilterLimits<T>::unit_roundoff;
  const detail::FilterBounds<T> bounds = {8 * u * y * z + FilterLimits<T>::tiny,
                                          48 * u * x * y * z + FilterLimits<T>::tiny};
  int parity = 0;
  for (int f = 0; f < table.face_count; ++f) {
    const auto& v = table.faces[f].vertices;
    const bool quad = table.faces[f].vertex_count == 4;
    unsigned shared = vertex_sides[v[0]] & vertex_sides[v[1]] & vertex_sides[v[2]];
    if (quad)
      shared &= vertex_sides[v[3]];
    if ((shared & (detail::beside | detail::behind)) != 0)
      continue; // the ray cannot meet it
    const bool in_front = (shared & detail::front) != 0;
    const int count =
        quad ? detail::patch_crossings(r[v[0]], r[v[1]], r[v[2]], r[v[3]], in_front, bounds)
             : detail::triangle_crossings(r[v[0]], r[v[1]], r[v[2]], in_front, bounds);
    if (count == math::undecided)
      return FilterResult::undecided;
    parity ^= count;
  }
  return parity != 0 ? FilterResult::inside : FilterResult::outside;
}

} // namespace insitu::cells
