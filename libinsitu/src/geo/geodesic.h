#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/vec.h"

namespace insitu::geo {

/// `count` points in equal steps of length along the geodesic of WGS84 from one longitude, latitude
/// (degrees), height (metres) to another, both included; the third number goes in equal steps. A
/// single point lies in the middle. Throws core::Error (INSITU_ERROR_ARGUMENT) for a latitude out
/// of range.
std::vector<math::Vec3d> geodesic(const math::Vec3d& from, const math::Vec3d& to,
                                  std::int64_t count);

/// Places along a path, with their distance along it from its first place.
struct Path {
  std::vector<math::Vec3d> places; ///< longitude, latitude (degrees), 0
  std::vector<double> distances;   ///< metres on the ellipsoid
};

/// `count` (2 or more) places in equal steps of length along the geodesics of WGS84 from each of
/// `through` (longitude, latitude in degrees; the third number is not read) to the next; the first
/// and the last of them as written. Throws core::Error (INSITU_ERROR_ARGUMENT) for a latitude out
/// of range, and for a path without length.
Path geodesic_path(std::span<const math::Vec3d> through, std::int64_t count);

/// How far the ellipsoid's places are apart, and in which direction one lies from the other
/// (longitude, latitude in degrees; the third number is not read): C. F. F. Karney, Algorithms for
/// geodesics, J. Geodesy 87, 2013.
struct Separation {
  double distance; ///< metres, to 15 nanometres
  double
      bearing; ///< at `from`, degrees clockwise from north, 0 <= bearing < 360; NaN at distance 0
};
Separation separation(const math::Vec3d& from, const math::Vec3d& to);

} // namespace insitu::geo
