#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>

#include "math/exact_integer.h"
#include "math/predicates.h"

/// The predicates of predicates.h, decided for every finite input: filter in double, then
/// double-double, then integers of as many bits as it takes. Host only.
namespace insitu::math {

namespace detail {

struct ExactVec3 {
  ExactInteger x, y, z;
};

inline int lowest_exponent(std::initializer_list<Vec3d> points) {
  int lowest = 1024;
  for (const Vec3d& p : points) {
    for (int axis = 0; axis < 3; ++axis) {
      lowest = std::min(lowest, math::lowest_exponent(p[axis]));
    }
  }
  return lowest;
}

inline ExactVec3 exact_difference(const Vec3d& a, const Vec3d& b, int exponent) {
  return {ExactInteger(a.x, exponent) - ExactInteger(b.x, exponent),
          ExactInteger(a.y, exponent) - ExactInteger(b.y, exponent),
          ExactInteger(a.z, exponent) - ExactInteger(b.z, exponent)};
}

inline ExactVec3 exact_cross(const ExactVec3& a, const ExactVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline ExactInteger exact_dot(const ExactVec3& a, const ExactVec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

} // namespace detail

inline int orient2d_exact(double ax, double ay, double bx, double by, double cx, double cy) {
  const int e = detail::lowest_exponent({{ax, ay, 0.0}, {bx, by, 0.0}, {cx, cy, 0.0}});
  const ExactInteger x(cx, e), y(cy, e);
  const ExactInteger left = (ExactInteger(ax, e) - x) * (ExactInteger(by, e) - y);
  const ExactInteger right = (ExactInteger(ay, e) - y) * (ExactInteger(bx, e) - x);
  return (left - right).sign();
}

inline int orient3d_exact(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const int e = detail::lowest_exponent({a, b, c, d});
  return exact_dot(
             detail::exact_difference(a, d, e),
             exact_cross(detail::exact_difference(b, d, e), detail::exact_difference(c, d, e)))
      .sign();
}

inline int bilinear_side_exact(const Vec3d& p00, const Vec3d& p10, const Vec3d& p11,
                               const Vec3d& p01, const Vec3d& q) {
  using namespace detail;
  const int e = detail::lowest_exponent({p00, p10, p11, p01, q});
  const ExactVec3 r00 = exact_difference(p00, q, e), r10 = exact_difference(p10, q, e),
                  r11 = exact_difference(p11, q, e), r01 = exact_difference(p01, q, e);
  const ExactVec3 first = exact_cross(r00, r10), second = exact_cross(r11, r01);
  // The signs of a and c are both flipped against predicates.h, which their product forgets.
  const ExactInteger a = exact_dot(r10, second), b = exact_dot(r00, second);
  const ExactInteger c = exact_dot(r01, first), d = exact_dot(r11, first);
  return (a * c - b * d).sign();
}

/// Calls the stages in turn and remembers the deepest one that was needed.
struct Predicates {
  Stage deepest = Stage::filter;

  int orient2d(double ax, double ay, double bx, double by, double cx, double cy) {
    int sign = orient2d_filter(ax, ay, bx, by, cx, cy);
    if (sign != undecided)
      return sign;
    sign = orient2d_double_double(ax, ay, bx, by, cx, cy);
    if (note(sign))
      return sign;
    return orient2d_exact(ax, ay, bx, by, cx, cy);
  }

  int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    int sign = orient3d_filter(a, b, c, d);
    if (sign != undecided)
      return sign;
    sign = orient3d_double_double(a, b, c, d);
    if (note(sign))
      return sign;
    return orient3d_exact(a, b, c, d);
  }

  int bilinear_side(const Vec3d& p00, const Vec3d& p10, const Vec3d& p11, const Vec3d& p01,
                    const Vec3d& q) {
    int sign = bilinear_side_filter(p00, p10, p11, p01, q);
    if (sign != undecided)
      return sign;
    sign = bilinear_side_double_double(p00, p10, p11, p01, q);
    if (note(sign))
      return sign;
    return bilinear_side_exact(p00, p10, p11, p01, q);
  }

private:
  bool note(int sign) {
    const bool decided = sign != undecided;
    deepest = std::max(deepest, decided ? Stage::double_double : Stage::exact);
    return decided;
  }
};

} // namespace insitu::math
