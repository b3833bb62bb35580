#include "geo/geodesic.h"

#include <cmath>
#include <string>

#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/GeodesicLine.hpp>

#include "core/status.h"

namespace insitu::geo {

std::vector<math::Vec3d> geodesic(const math::Vec3d& from, const math::Vec3d& to,
                                  std::int64_t count) {
  for (const math::Vec3d& p : {from, to})
    if (!(std::fabs(p.y) <= 90.0))
      throw core::Error(INSITU_ERROR_ARGUMENT,
                        "transect: latitude " + std::to_string(p.y) + ", -90 to 90 expected");
  const auto line =
      GeographicLib::Geodesic::WGS84().InverseLine(from.y, from.x, to.y, to.x);
  std::vector<math::Vec3d> points;
  for (std::int64_t i = 0; i < count; ++i) {
    const double s = count > 1 ? double(i) / double(count - 1) : 0.5;
    double latitude, longitude;
    line.Position(s * line.Distance(), latitude, longitude);
    points.push_back({longitude, latitude, from.z + s * (to.z - from.z)});
  }
  if (count > 1) { // the ends as written
    points.front() = from;
    points.back() = to;
  }
  return points;
}

} // namespace insitu::geo
