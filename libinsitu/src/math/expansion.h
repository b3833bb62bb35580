#pragma once

#include "math/hd.h"

/// Error-free transforms and double-double numbers.
///
/// They hold for IEEE double arithmetic rounded to nearest with gradual underflow, compiled without
/// contraction and without -ffast-math. There is no fused multiply-add on purpose: the baseline
/// x86-64 target has none, and one spelling gives the same bits on every target.
namespace insitu::math {

/// The unevaluated sum hi + lo, |lo| <= ulp(hi) / 2.
struct DoubleDouble {
  double hi = 0.0, lo = 0.0;
};

/// a + b = hi + lo exactly, if |a| >= |b| or a = 0. (Dekker 1971)
INSITU_HD constexpr DoubleDouble fast_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

/// a + b = hi + lo exactly, unless the sum overflows. (Knuth, TAOCP 2, 4.2.2)
INSITU_HD constexpr DoubleDouble two_sum(double a, double b) {
  const double s = a + b;
  const double b_part = s - a;
  const double a_part = s - b_part;
  return {s, (a - a_part) + (b - b_part)};
}

/// a - b = hi + lo exactly, unless the difference overflows.
INSITU_HD constexpr DoubleDouble two_difference(double a, double b) {
  return two_sum(a, -b);
}

/// a * b = hi + lo exactly, if |a|, |b| < 2^996, |a b| < 2^1021 and a b is 0 or at least 2^-968;
/// below that lo is off by less than 2^-1071. (Veltkamp's split, Dekker's product)
INSITU_HD constexpr DoubleDouble two_product(double a, double b) {
  constexpr double splitter = 134217729.0; // 2^27 + 1
  const double p = a * b;
  const double a_scaled = splitter * a;
  const double a_high = a_scaled - (a_scaled - a);
  const double a_low = a - a_high;
  const double b_scaled = splitter * b;
  const double b_high = b_scaled - (b_scaled - b);
  const double b_low = b - b_high;
  return {p, ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

INSITU_HD constexpr DoubleDouble operator-(DoubleDouble a) {
  return {-a.hi, -a.lo};
}

/// Relative error at most 3u^2 + 13u^3, u = 2^-53, whatever the signs.
/// (Joldes, Muller, Popescu 2017, "Tight and rigorous error bounds for basic building blocks of
/// double-word arithmetic", algorithm 6)
INSITU_HD constexpr DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble high = two_sum(a.hi, b.hi);
  const DoubleDouble low = two_sum(a.lo, b.lo);
  const DoubleDouble first = fast_two_sum(high.hi, high.lo + low.hi);
  return fast_two_sum(first.hi, low.lo + first.lo);
}

INSITU_HD constexpr DoubleDouble operator-(DoubleDouble a, DoubleDouble b) {
  return a + (-b);
}

/// Relative error at most 7u^2, barring underflow. (the same, algorithm 10)
INSITU_HD constexpr DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble p = two_product(a.hi, b.hi);
  const double cross = a.hi * b.lo + a.lo * b.hi;
  return fast_two_sum(p.hi, p.lo + cross);
}

} // namespace insitu::math
