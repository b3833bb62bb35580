#pragma once

#include <algorithm>
#include <cmath>

#include "geo/chart.h"
#include "mesh/box.h"

namespace insitu::commit {

/// How far from a cell the faces of other processes may lie that are compared with its own: a part
/// of the cell's size, on a mesh in longitude and latitude of its size in metres.
struct SeamReach {
  double tolerance = 0.0;                 ///< in the diameter of a face
  const geo::ChartUnits* units = nullptr; ///< of a mesh in longitude and latitude

  /// A box of the mesh's coordinates, of a cell or of cells that are of this size at most, together
  /// with what may be compared with them. Faces that are near each other differ in their diameters
  /// by twice the tolerance at most, so each is within the reach of the other's cell.
  mesh::Box widened(const mesh::Box& box, const math::Vec3d& size) const {
    if (tolerance == 0.0)
      return box;
    constexpr double more = 1.3; // above 1 / (1 - 2 tolerance), and the Earth is not a sphere
    const math::Vec3d by = of_distance(more * tolerance * diameter(box, size), box);
    return {box.low - by, box.high + by};
  }

private:
  /// The latitude of a box that is nearest to the equator, where longitudes are furthest apart.
  static double lowest_latitude(const mesh::Box& box) {
    return std::max({0.0, box.low.y, -box.high.y});
  }
  double diameter(const mesh::Box& box, const math::Vec3d& size) const {
    math::Vec3d metres = size;
    if (units)
      metres =
          geo::chart_metres(*units, geo::Pole::none, {0, lowest_latitude(box), box.high.z}, size);
    return std::sqrt(dot(metres, metres));
  }
  /// A distance in the mesh's coordinates. Between faces that are near each other the longitudes
  /// are so where the faces are nearest to the equator.
  math::Vec3d of_distance(double distance, const mesh::Box& box) const {
    if (!units)
      return {distance, distance, distance};
    const double latitude = std::min(lowest_latitude(box), 0.9999 * units->quarter());
    const math::Vec3d by = geo::chart_rates(*units, geo::Pole::none, {0, latitude, box.low.z},
                                            {distance, distance, distance});
    return {std::min(by.x, units->quarter()), by.y, std::abs(by.z)};
  }
};

} // namespace insitu::commit
