#pragma once

#include <cmath>

#include "math/hd.h"

/// The few operations that kernels need beyond + - * / and comparisons, for scalars. A SIMD pack
/// brings its own overloads, found by argument-dependent lookup; comparisons then give its mask.
namespace insitu::math {

/// Coordinates beyond do not fit a float box with its margins.
inline constexpr double largest_coordinate = 1e37;

INSITU_HD inline double select(bool m, double a, double b) {
  return m ? a : b;
}
INSITU_HD inline float select(bool m, float a, float b) {
  return m ? a : b;
}
INSITU_HD inline bool select(bool m, bool a, bool b) {
  return m ? a : b;
}
INSITU_HD inline bool all_of(bool m) {
  return m;
}
INSITU_HD inline double absolute(double a) {
  return std::fabs(a);
}
INSITU_HD inline float absolute(float a) {
  return std::fabs(a);
}
INSITU_HD inline double smaller(double a, double b) {
  return a < b ? a : b;
}
INSITU_HD inline float smaller(float a, float b) {
  return a < b ? a : b;
}
INSITU_HD inline double larger(double a, double b) {
  return a > b ? a : b;
}
INSITU_HD inline float larger(float a, float b) {
  return a > b ? a : b;
}

} // namespace insitu::math
