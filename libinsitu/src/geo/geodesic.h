#pragma once

#include <cstdint>
#include <vector>

#include "math/vec.h"

namespace insitu::geo {

/// `count` points in equal steps of length along the geodesic of WGS84 from one longitude, latitude
/// (degrees), height (metres) to another, both included; the third number goes in equal steps. A
/// single point lies in the middle. Throws core::Error (INSITU_ERROR_ARGUMENT) for a latitude out of
/// range.
std::vector<math::Vec3d> geodesic(const math::Vec3d& from, const math::Vec3d& to,
                                  std::int64_t count);

} // namespace insitu::geo
