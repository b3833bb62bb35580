#pragma once

namespace insitu::core {

/// The same number, but 0 for -0: times and coordinates are printed without a sign of zero.
inline double unsigned_zero(double x) {
  return x + 0.0;
}

} // namespace insitu::core
