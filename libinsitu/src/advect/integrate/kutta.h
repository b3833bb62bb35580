#pragma once

#include "math/hd.h"
#include "math/vec.h"

namespace insitu::advect {

/// Where evaluation s (from 0) of Kutta's method of order 4 asks for the velocity, the last at the
/// end of the step; one text for the host and for devices. Velocities of later stages are not read.
INSITU_HD inline math::Vec3d kutta_point(int s, const math::Vec3d& x, double h,
                                         const math::Vec3d& k1, const math::Vec3d& k2,
                                         const math::Vec3d& k3, const math::Vec3d& k4) {
  switch (s) {
  case 0:
    return x + (0.5 * h) * k1;
  case 1:
    return x + (0.5 * h) * k2;
  case 2:
    return x + h * k3;
  default:
    return x + ((h / 6) * k1 + (h / 3) * k2 + (h / 3) * k3 + (h / 6) * k4);
  }
}

} // namespace insitu::advect
