#include "geo/geodesic.h"

#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/GeodesicLine.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/status.h"

namespace insitu::geo {

namespace {

void check_latitude(const char* what, const math::Vec3d& p) {
  if (!(std::fabs(p.y) <= 90.0))
    throw core::Error(INSITU_ERROR_ARGUMENT, std::string(what) + ": latitude " +
                                                 std::to_string(p.y) + ", -90 to 90 expected");
}

} // namespace

std::vector<math::Vec3d> geodesic(const math::Vec3d& from, const math::Vec3d& to,
                                  std::int64_t count) {
  for (const math::Vec3d& p : {from, to})
    check_latitude("transect", p);
  const auto line = GeographicLib::Geodesic::WGS84().InverseLine(from.y, from.x, to.y, to.x);
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

Path geodesic_path(std::span<const math::Vec3d> through, std::int64_t count) {
  std::vector<GeographicLib::GeodesicLine> legs;
  std::vector<double> begins{0.0}; // of the legs, and where the last one ends
  for (const math::Vec3d& p : through)
    check_latitude("curtain", p);
  for (std::size_t i = 0; i + 1 < through.size(); ++i) {
    const math::Vec3d &from = through[i], &to = through[i + 1];
    legs.push_back(GeographicLib::Geodesic::WGS84().InverseLine(from.y, from.x, to.y, to.x));
    begins.push_back(begins.back() + legs.back().Distance());
  }
  const double length = begins.back();
  if (!(length > 0.0))
    throw core::Error(INSITU_ERROR_ARGUMENT, "curtain: the path has no length");
  Path path;
  for (std::int64_t i = 0; i < count; ++i) {
    const double s = length * (double(i) / double(count - 1));
    const auto after = std::upper_bound(begins.begin() + 1, begins.end() - 1, s);
    const auto leg = std::size_t(after - begins.begin()) - 1;
    double latitude, longitude;
    legs[leg].Position(s - begins[leg], latitude, longitude);
    path.places.push_back({longitude, latitude, 0.0});
    path.distances.push_back(s);
  }
  path.places.front() = {through.front().x, through.front().y, 0.0};
  path.places.back() = {through.back().x, through.back().y, 0.0};
  return path;
}

Separation separation(const math::Vec3d& from, const math::Vec3d& to) {
  double distance, bearing, there;
  GeographicLib::Geodesic::WGS84().Inverse(from.y, from.x, to.y, to.x, distance, bearing, there);
  if (!(distance > 0.0))
    return {distance, std::numeric_limits<double>::quiet_NaN()};
  if (bearing < 0.0)
    bearing += 360.0;
  return {distance, bearing < 360.0 ? bearing : 0.0}; // a tiny negative one rounds to 360
}

} // namespace insitu::geo
