#pragma once

#include <cmath>

#include "geo/chart.h"

/// Geocentric points and the ellipsoid's normals through them, without angles: for what asks at
/// every step of a particle.
namespace insitu::geo {

/// A geocentric point, by the normal on whose line it lies and its height along it.
struct Upright {
  math::Vec3d normal; ///< unit, outwards
  double height;      ///< metres
};

/// Where that is.
inline math::Vec3d geocentric_point(const Upright& at) {
  const double across = radii(at.normal.z).across, up = across + at.height;
  return {up * at.normal.x, up * at.normal.y,
          (across * (1 - eccentricity_squared) + at.height) * at.normal.z};
}

/// The inverse, by Bowring's iteration for the parametric latitude u (Survey Review 23, 1976, with
/// the first guess of Survey Review 28, 1985, which leaves 1e-9 at heights of 1000 km; each round
/// squares that):
///
///   tan(lat) = (z + e'^2 b sin^3 u) / (p - e^2 a cos^3 u),   tan u = (1 - f) tan(lat)
///
/// Within 50 km of the Earth's centre, where normals cross, the normal is the direction from there.
inline Upright upright(const math::Vec3d& x) {
  constexpr double a = equatorial_radius, e2 = eccentricity_squared, b = a * (1 - flattening),
                   second = e2 / (1 - e2), crossing = 5e4;
  const double p = std::hypot(x.x, x.y), r = std::hypot(p, x.z);
  double c = 0.0, s = 1.0; // of the latitude
  if (r > crossing) {
    double u = a * p, v = b * x.z * (1 + second * b / r); // along cos u, sin u
    for (int round = 0; round < 2; ++round) {
      const double n = std::hypot(u, v), cu = u / n, su = v / n;
      c = p - e2 * a * cu * cu * cu;
      s = x.z + second * b * su * su * su;
      u = c;
      v = (1 - flattening) * s;
    }
    const double n = std::hypot(c, s);
    c /= n;
    s /= n;
  } else if (r > 0.0) {
    c = p / r;
    s = x.z / r;
  }
  const double longitude_x = p > 0.0 ? x.x / p : 1.0, longitude_y = p > 0.0 ? x.y / p : 0.0;
  return {{c * longitude_x, c * longitude_y, s}, p * c + x.z * s - a * std::sqrt(1 - e2 * s * s)};
}

/// The vector of this many metres east, north and up at a normal, in the Earth's axes, and back; at
/// a pole, east and north are those of longitude 0.
inline math::Vec3d from_east_north_up(const math::Vec3d& normal, const math::Vec3d& v) {
  const EastNorth axes = east_north(normal);
  return v.x * axes.east + v.y * axes.north + v.z * normal;
}
inline math::Vec3d to_east_north_up(const math::Vec3d& normal, const math::Vec3d& v) {
  const EastNorth axes = east_north(normal);
  return {dot(v, axes.east), dot(v, axes.north), dot(v, normal)};
}

/// The normal, from one at `height`, m metres (in the Earth's axes, at right angles to it) further
/// on along a great circle of the sphere of normals.
inline math::Vec3d level_way(const Upright& from, const math::Vec3d& m) {
  const EastNorth axes = east_north(from.normal);
  const Radii r = radii(from.normal.z);
  const math::Vec3d turns = (dot(m, axes.east) / (r.across + from.height)) * axes.east +
                            (dot(m, axes.north) / (r.along + from.height)) * axes.north;
  const double angle = std::sqrt(dot(turns, turns));
  return angle > 0.0 ? std::cos(angle) * from.normal + (std::sin(angle) / angle) * turns
                     : from.normal;
}

} // namespace insitu::geo
