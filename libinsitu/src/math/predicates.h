#pragma once

#include <cmath>
#include <cstdint>

#include "math/expansion.h"
#include "math/number.h"
#include "math/vec.h"

/// Signs of determinants, certified by an error bound or given as `undecided`; host and device.
///
///   orient2d(a, b, c)          sign of det(a - c, b - c): positive for a counterclockwise triangle
///   orient3d(a, b, c, d)       sign of det(a - d, b - d, c - d): positive where a, b, c turn
///                              clockwise seen from d
///   bilinear_side(quad, q)     sign of a c - b d, with a, b, c, d the signed volumes of q against
///   the
///                              tetrahedron of the quad's corners p00, p10, p11, p01. q must lie in
///                              that closed tetrahedron: there the bilinear patch is a c = b d
///                              exactly, and a c > b d is the side of the diagonal p00-p11. (S(u,v)
///                              has the weights (1-u)(1-v), u(1-v), u v, (1-u) v.)
///
/// `*_filter` works in double, `*_double_double` in double-double; predicates_exact.h settles the
/// rest. A decided sign is right for every finite input: products that may overflow are left
/// undecided, and the bounds contain what underflow can lose. NaN and infinity are undecided.
namespace insitu::math {

/// What a predicate returns in place of a sign when its error bound cannot tell.
inline constexpr int undecided = 2;

/// Constants of the filters. Bounds on rounding: Shewchuk 1997, "Adaptive precision floating-point
/// arithmetic and fast robust geometric predicates", stage A, (3 + 16u) u and (7 + 56u) u times
/// the sum of the absolute products, rounded up here. `tiny` is more than the underflow of every
/// product together, given differences of at most `max_difference`.
template <class T>
struct FilterLimits;

template <>
struct FilterLimits<double> {
  static constexpr double unit_roundoff = 0x1p-53;
  static constexpr double max_difference = 0x1p150;
  static constexpr double tiny = 0x1p-900;
};

template <>
struct FilterLimits<float> {
  static constexpr float unit_roundoff = 0x1p-24f;
  static constexpr float max_difference = 0x1p20f;
  static constexpr float tiny = 0x1p-120f;
};

/// The sign of `value` known to within `bound`; NaN in either gives undecided.
template <class T>
INSITU_HD constexpr int certified_sign(T value, T bound) {
  return value > bound ? 1 : (value < -bound ? -1 : undecided);
}

namespace detail {

using math::absolute;
INSITU_HD constexpr double nonzero(double x) {
  return x != 0.0 ? 1.0 : 0.0;
}
INSITU_HD constexpr Vec3d nonzero(const Vec3d& a) {
  return {nonzero(a.x), nonzero(a.y), nonzero(a.z)};
}
INSITU_HD inline Vec3d absolute(const Vec3d& a) {
  return {absolute(a.x), absolute(a.y), absolute(a.z)};
}
INSITU_HD inline bool in_range(const Vec3d& a) {
  constexpr double limit = FilterLimits<double>::max_difference;
  return absolute(a.x) <= limit && absolute(a.y) <= limit && absolute(a.z) <= limit;
}

/// The determinant of three rows, and the same with every minus turned into a plus.
INSITU_HD constexpr double determinant(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return a.z * (b.x * c.y - c.x * b.y) + b.z * (c.x * a.y - a.x * c.y) +
         c.z * (a.x * b.y - b.x * a.y);
}
INSITU_HD constexpr double permanent(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return a.z * (b.x * c.y + c.x * b.y) + b.z * (c.x * a.y + a.x * c.y) +
         c.z * (a.x * b.y + b.x * a.y);
}

/// a - b with no error.
struct Difference3 {
  DoubleDouble x, y, z;
};
INSITU_HD constexpr Difference3 exact_difference(const Vec3d& a, const Vec3d& b) {
  return {two_difference(a.x, b.x), two_difference(a.y, b.y), two_difference(a.z, b.z)};
}
INSITU_HD constexpr Vec3d rounded(const Difference3& a) {
  return {a.x.hi, a.y.hi, a.z.hi};
}
INSITU_HD constexpr DoubleDouble determinant(const Difference3& a, const Difference3& b,
                                             const Difference3& c) {
  return a.z * (b.x * c.y - c.x * b.y) + b.z * (c.x * a.y - a.x * c.y) +
         c.z * (a.x * b.y - b.x * a.y);
}

/// Double-double determinants pass through at most five operations of relative error 7u^2 each:
/// 36 u^2 times the permanent, and 64 u^2 = 2^-100 covers the rounding of the bound itself.
inline constexpr double double_double_factor = 0x1p-100;

} // namespace detail

INSITU_HD inline int orient2d_filter(double ax, double ay, double bx, double by, double cx,
                                     double cy) {
  const double adx = ax - cx, ady = ay - cy, bdx = bx - cx, bdy = by - cy;
  if (!detail::in_range({adx, ady, 0.0}) || !detail::in_range({bdx, bdy, 0.0}))
    return undecided;
  const double left = adx * bdy, right = ady * bdx;
  const double bound =
      4 * FilterLimits<double>::unit_roundoff * (detail::absolute(left) + detail::absolute(right)) +
      FilterLimits<double>::tiny;
  const int sign = certified_sign(left - right, bound);
  if (sign != undecided)
    return sign;
  // Both products vanish because a factor does, not by underflow: zero, and known to be.
  const bool zero = (adx == 0.0 || bdy == 0.0) && (ady == 0.0 || bdx == 0.0);
  return zero ? 0 : undecided;
}

INSITU_HD inline int orient2d_double_double(double ax, double ay, double bx, double by, double cx,
                                            double cy) {
  using namespace detail;
  const DoubleDouble adx = two_difference(ax, cx), ady = two_difference(ay, cy);
  const DoubleDouble bdx = two_difference(bx, cx), bdy = two_difference(by, cy);
  if (!in_range({adx.hi, ady.hi, 0.0}) || !in_range({bdx.hi, bdy.hi, 0.0}))
    return undecided;
  const DoubleDouble value = adx * bdy - ady * bdx;
  const double sum = absolute(adx.hi * bdy.hi) + absolute(ady.hi * bdx.hi);
  return certified_sign(value.hi, double_double_factor * sum + FilterLimits<double>::tiny);
}

INSITU_HD inline int orient3d_filter(const Vec3d& a, const Vec3d& b, const Vec3d& c,
                                     const Vec3d& d) {
  using namespace detail;
  const Vec3d ad = a - d, bd = b - d, cd = c - d;
  if (!in_range(ad) || !in_range(bd) || !in_range(cd))
    return undecided;
  const double sum = permanent(absolute(ad), absolute(bd), absolute(cd));
  const double bound = 8 * FilterLimits<double>::unit_roundoff * sum + FilterLimits<double>::tiny;
  const int sign = certified_sign(determinant(ad, bd, cd), bound);
  if (sign != undecided)
    return sign;
  return permanent(nonzero(ad), nonzero(bd), nonzero(cd)) == 0.0 ? 0 : undecided;
}

INSITU_HD inline int orient3d_double_double(const Vec3d& a, const Vec3d& b, const Vec3d& c,
                                            const Vec3d& d) {
  using namespace detail;
  const Difference3 ad = exact_difference(a, d), bd = exact_difference(b, d),
                    cd = exact_difference(c, d);
  const Vec3d ar = rounded(ad), br = rounded(bd), cr = rounded(cd);
  if (!in_range(ar) || !in_range(br) || !in_range(cr))
    return undecided;
  const double sum = permanent(absolute(ar), absolute(br), absolute(cr));
  return certified_sign(determinant(ad, bd, cd).hi,
                        double_double_factor * sum + FilterLimits<double>::tiny);
}

/// The bound on a c - b d when a, b, c, d are each off by at most `error` and the products and
/// their difference are rounded with relative error `roundoff`.
template <class T>
INSITU_HD inline T bilinear_bound(T a, T b, T c, T d, T error, T roundoff) {
  const T sum = std::fabs(a) + std::fabs(b) + std::fabs(c) + std::fabs(d);
  const T products = std::fabs(a * c) + std::fabs(b * d);
  return T(1.01) * (error * (sum + 2 * error) + roundoff * products) + FilterLimits<T>::tiny;
}

namespace detail {
INSITU_HD inline double largest_permanent(const Vec3d& a, const Vec3d& b, const Vec3d& c,
                                          const Vec3d& d) {
  return std::fmax(std::fmax(permanent(b, c, d), permanent(a, c, d)),
                   std::fmax(permanent(a, b, d), permanent(a, b, c)));
}
} // namespace detail

INSITU_HD inline int bilinear_side_filter(const Vec3d& p00, const Vec3d& p10, const Vec3d& p11,
                                          const Vec3d& p01, const Vec3d& q) {
  using namespace detail;
  const Vec3d r00 = p00 - q, r10 = p10 - q, r11 = p11 - q, r01 = p01 - q;
  if (!in_range(r00) || !in_range(r10) || !in_range(r11) || !in_range(r01))
    return undecided;
  constexpr double u = FilterLimits<double>::unit_roundoff;
  const double largest =
      largest_permanent(absolute(r00), absolute(r10), absolute(r11), absolute(r01));
  const double error = 8 * u * largest + FilterLimits<double>::tiny;
  const double a = -determinant(r10, r11, r01), b = determinant(r00, r11, r01);
  const double c = -determinant(r00, r10, r01), d = determinant(r00, r10, r11);
  return certified_sign(a * c - b * d, bilinear_bound(a, b, c, d, error, 4 * u));
}

INSITU_HD inline int bilinear_side_double_double(const Vec3d& p00, const Vec3d& p10,
                                                 const Vec3d& p11, const Vec3d& p01,
                                                 const Vec3d& q) {
  using namespace detail;
  const Difference3 r00 = exact_difference(p00, q), r10 = exact_difference(p10, q),
                    r11 = exact_difference(p11, q), r01 = exact_difference(p01, q);
  const Vec3d h00 = rounded(r00), h10 = rounded(r10), h11 = rounded(r11), h01 = rounded(r01);
  if (!in_range(h00) || !in_range(h10) || !in_range(h11) || !in_range(h01))
    return undecided;
  const double largest =
      largest_permanent(absolute(h00), absolute(h10), absolute(h11), absolute(h01));
  const double error = double_double_factor * largest + FilterLimits<double>::tiny;
  const DoubleDouble a = -determinant(r10, r11, r01), b = determinant(r00, r11, r01);
  const DoubleDouble c = -determinant(r00, r10, r01), d = determinant(r00, r10, r11);
  return certified_sign((a * c - b * d).hi,
                        bilinear_bound(a.hi, b.hi, c.hi, d.hi, error, double_double_factor));
}

/// How far a predicate had to go.
enum class Stage : std::uint8_t { filter, double_double, exact };

/// The first two stages in turn. Where they cannot tell a sign it is given as 0, and all that
/// follows from it means nothing: `failed`.
struct DoubleDoublePredicates {
  Stage deepest = Stage::filter;
  bool failed = false;

  INSITU_HD int orient2d(double ax, double ay, double bx, double by, double cx, double cy) {
    const int sign = orient2d_filter(ax, ay, bx, by, cx, cy);
    return sign != undecided ? sign : note(orient2d_double_double(ax, ay, bx, by, cx, cy));
  }
  INSITU_HD int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    const int sign = orient3d_filter(a, b, c, d);
    return sign != undecided ? sign : note(orient3d_double_double(a, b, c, d));
  }
  INSITU_HD int bilinear_side(const Vec3d& p00, const Vec3d& p10, const Vec3d& p11,
                              const Vec3d& p01, const Vec3d& q) {
    const int sign = bilinear_side_filter(p00, p10, p11, p01, q);
    return sign != undecided ? sign : note(bilinear_side_double_double(p00, p10, p11, p01, q));
  }

private:
  INSITU_HD int note(int sign) {
    deepest = Stage::double_double;
    failed = failed || sign == undecided;
    return sign == undecided ? 0 : sign;
  }
};

} // namespace insitu::math
