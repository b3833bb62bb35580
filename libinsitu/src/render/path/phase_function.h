#pragma once

#include <algorithm>
#include <cmath>

#include "math/vec.h"

namespace insitu::render {

constexpr double pi = 3.14159265358979323846;

/// The share of scattered light that goes into a direction, per steradian: Henyey and Greenstein
/// (1941). cosine: of the angle between the directions of flight before and after; g: the mean
/// cosine, in (-1, 1), 0 for isotropic.
inline double henyey_greenstein(double cosine, double g) {
  const double d = 1 + g * g - 2 * g * cosine;
  return (1 - g * g) / (4 * pi * d * std::sqrt(d));
}

/// A cosine distributed so; u uniform in [0, 1). The usual inversion, its division by g done by
/// hand: no cancellation at small g, and none of it is left at 0.
inline double sample_henyey_greenstein(double g, double u) {
  const double w = 2 * u - 1, d = 1 + g * w;
  const double n = w + g * (0.5 * (w * w + 3) + g * (w + 0.5 * g * (w * w - 1)));
  return std::clamp(n / (d * d), -1.0, 1.0);
}

/// The unit vector at this cosine and azimuth (in turns) around the unit vector n. The basis is
/// that of Duff et al. (2017), "Building an Orthonormal Basis, Revisited".
inline math::Vec3d direction_around(const math::Vec3d& n, double cosine, double azimuth) {
  const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
  const math::Vec3d x{1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  const math::Vec3d y{b, sign + n.y * n.y * a, -n.y};
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const math::Vec3d d = (sine * std::cos(2 * pi * azimuth)) * x +
                        (sine * std::sin(2 * pi * azimuth)) * y + cosine * n;
  return d / std::sqrt(dot(d, d)); // rounding must not build up over many bounces
}

} // namespace insitu::render
