#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "geo/chart.h"
#include "mesh/box.h"

namespace insitu::query {

/// Where a point of a geodetic mesh lies among its cells. Every point has one image: its longitude
/// within [west, west + turn), or, from the latitude on where cells hold a pole, its place on the
/// chart turned to that pole, set down far to the east of all other cells. So it is located once,
/// and in one tree.
struct ChartImage {
  geo::ChartUnits units = {};
  double west = 0.0;
  /// From these latitudes on (northwards; southwards) the turned charts are used: beyond any, if no
  /// cell holds the pole.
  double north_from = std::numeric_limits<double>::infinity();
  double south_from = -std::numeric_limits<double>::infinity();

  geo::Pole pole_at(double latitude) const {
    return latitude >= north_from   ? geo::Pole::north
           : latitude <= south_from ? geo::Pole::south
                                    : geo::Pole::none;
  }
  /// What is added to a turned chart's longitudes, which lie within a quarter turn of 0; longitudes
  /// of cells that reach over the seam end half a turn beyond it.
  double offset(geo::Pole pole) const {
    const double turns = pole == geo::Pole::north   ? 11.0 / 6
                         : pole == geo::Pole::south ? 15.0 / 6
                                                    : 0.0;
    return pole == geo::Pole::none ? 0.0 : west + turns * units.turn();
  }
  /// The pole to whose chart an image belongs: those on turned charts lie more than half a turn
  /// east of all others.
  geo::Pole pole_of(const math::Vec3d& image) const {
    const double turns = (image.x - west) / units.turn();
    return turns <= 1.5 ? geo::Pole::none : turns < 13.0 / 6 ? geo::Pole::north : geo::Pole::south;
  }
  math::Vec3d turned(geo::Pole pole, const math::Vec3d& p) const {
    math::Vec3d q = geo::between_charts(units, geo::Pole::none, pole, p);
    q.x += offset(pole);
    return q;
  }
  math::Vec3d operator()(const math::Vec3d& p) const {
    const geo::Pole pole = pole_at(p.y);
    if (pole == geo::Pole::none)
      return with_longitude(p);
    if (!(std::abs(p.y) <= units.quarter()) || !std::isfinite(p.x)) // beyond a pole is nowhere
      return {std::numeric_limits<double>::quiet_NaN(), p.y, p.z};
    return turned(pole, p);
  }
  /// The same place, its longitude within [west, west + turn).
  math::Vec3d with_longitude(const math::Vec3d& p) const {
    return {geo::longitude_from(west, units, p.x), p.y, p.z};
  }
  /// Where the chart begins and ends: copies of cells over its seam reach further.
  void cut(mesh::Box& box) const {
    box.low.x = std::max(box.low.x, west);
    box.high.x = std::min(box.high.x, west + units.turn());
  }
  /// The point of which this is an image, or a place among the cells around one.
  math::Vec3d point_of(const math::Vec3d& image) const {
    const geo::Pole pole = pole_of(image);
    return with_longitude(geo::between_charts(units, pole, geo::Pole::none,
                                              {image.x - offset(pole), image.y, image.z}));
  }
};

} // namespace insitu::query
