#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace insitu::render {

/// What samples among some values may be: within [lower, upper], or no number. Doubles as fields
/// are: 1e-300 has no range in float.
struct PossibleValues {
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  double lower = infinity, upper = -infinity;
  bool nan = false; ///< or infinite

  void add(double v) {
    nan = nan || v - v != 0;
    v += 0.0; // one zero, so that it does not matter who comes first
    lower = v < lower ? v : lower;
    upper = v > upper ? v : upper;
  }
  /// Of one cell whose vertices were added; or of cells whose own values were, which are not
  /// interpolated.
  void finish(bool interpolated) {
    if (!nan && interpolated)
      widen(lower, upper);
    else if (nan && !is_infinite()) { // a NaN at one vertex is one everywhere in the cell
      lower = infinity;
      upper = -infinity;
    } else if (nan) {
      set_infinite();
    }
  }
  /// Of several cells, all of whose vertices were added: one's NaN leaves the others their range.
  void finish_several() {
    if (nan && is_infinite())
      set_infinite();
    else if (lower <= upper)
      widen(lower, upper);
  }

  /// By a millionth of the range and 16 roundings of the value, so that roundings of interpolation
  /// stay within.
  static void widen(double& low, double& high) {
    const double slack = 1e-6 * (high - low) + 0x1p-48 * std::max(std::fabs(low), std::fabs(high));
    low -= slack;
    high += slack;
  }

private:
  bool is_infinite() const { return lower <= upper && (lower == -infinity || upper == infinity); }
  /// What is between infinite and finite vertices.
  void set_infinite() {
    lower = -infinity;
    upper = infinity;
  }
};

} // namespace insitu::render
