#pragma once

#include <cmath>

#include "math/vec.h"

namespace insitu::workload {

/// The flow of Arnold, Beltrami and Childress (A, B, C = sqrt 3, sqrt 2, 1) with the unit box for
/// its period.
inline math::Vec3d abc_flow(const math::Vec3d& p) {
  const math::Vec3d x = (2.0 * M_PI) * p;
  const double a = std::sqrt(3.0), b = std::sqrt(2.0), c = 1.0;
  return {a * std::sin(x.z) + c * std::cos(x.y), b * std::sin(x.x) + a * std::cos(x.z),
          c * std::sin(x.y) + b * std::cos(x.x)};
}

} // namespace insitu::workload
