#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "math/vec.h"

/// Charts of the WGS84 ellipsoid: the coordinates in which a geodetic mesh is located and advected.
/// A point is the ellipsoid's unit normal n = (cos lat cos lon, cos lat sin lon, sin lat) and a
/// vertical number, which no conversion here touches: depth 0 stays exactly 0.
namespace insitu::geo {

/// What the numbers of a geodetic mesh count.
struct ChartUnits {
  bool radians = false;    ///< longitude, latitude; else degrees
  bool kilometres = false; ///< the vertical number; else metres
  bool down = false;       ///< it is a depth below the ellipsoid; else a height above

  bool operator==(const ChartUnits&) const = default;

  /// Once around.
  constexpr double turn() const { return radians ? 2 * std::numbers::pi : 360.0; }
  constexpr double quarter() const { return radians ? std::numbers::pi / 2 : 90.0; }
  constexpr double radians_per_unit() const { return radians ? 1.0 : std::numbers::pi / 180; }
  /// Metres upwards a vertical unit.
  constexpr double up_per_unit() const { return (kilometres ? 1000.0 : 1.0) * (down ? -1.0 : 1.0); }
};

struct SinCos {
  double sin, cos;
};

/// Exact at multiples of 90 degrees; the argument is reduced before it is turned into radians
/// (Karney's GeographicLib does the same).
inline SinCos sin_cos(const ChartUnits& units, double angle) {
  if (units.radians)
    return {std::sin(angle), std::cos(angle)};
  int quadrant = 0;
  const double r = std::remquo(angle, 90.0, &quadrant) * (std::numbers::pi / 180);
  const double s = std::sin(r), c = std::cos(r);
  switch (static_cast<unsigned>(quadrant) & 3U) {
  case 0:
    return {s, c};
  case 1:
    return {c, -s};
  case 2:
    return {-s, -c};
  default:
    return {-c, s};
  }
}

/// atan2 in the chart's units, exact at multiples of 90 degrees.
inline double angle_of(const ChartUnits& units, double y, double x) {
  if (units.radians)
    return std::atan2(y, x);
  constexpr double degrees = 180 / std::numbers::pi;
  if (std::abs(y) > std::abs(x)) // from the y axis
    return y > 0 ? 90.0 - std::atan2(x, y) * degrees : -90.0 + std::atan2(x, -y) * degrees;
  if (x < 0)
    return (std::signbit(y) ? -180.0 : 180.0) + std::atan2(-y, -x) * degrees;
  return std::atan2(y, x) * degrees;
}

/// Longitude and latitude, or those of the sphere of normals turned by a right angle so that a pole
/// comes to rest at (0, 0): these are regular around that pole, and singular only on the equator.
enum class Pole : std::int8_t { none, north, south };

/// To and from the turned sphere (rotations, so vectors and their handedness go along).
inline math::Vec3d turned(Pole pole, const math::Vec3d& n) {
  return pole == Pole::north   ? math::Vec3d{n.z, n.y, -n.x}
         : pole == Pole::south ? math::Vec3d{-n.z, n.y, n.x}
                               : n;
}
inline math::Vec3d turned_back(Pole pole, const math::Vec3d& n) {
  return pole == Pole::north   ? math::Vec3d{-n.z, n.y, n.x}
         : pole == Pole::south ? math::Vec3d{n.z, n.y, -n.x}
                               : n;
}

/// A place on a chart: the normal, and the chart's directions east and north there. In the plain
/// chart these are the true ones.
struct ChartPlace {
  math::Vec3d normal, east, north; ///< in the Earth's axes
  double cos_latitude;             ///< of the chart's own latitude
};

inline ChartPlace place_of(const ChartUnits& units, Pole pole, const math::Vec3d& p) {
  const SinCos lon = sin_cos(units, p.x), lat = sin_cos(units, p.y);
  return {turned_back(pole, {lat.cos * lon.cos, lat.cos * lon.sin, lat.sin}),
          turned_back(pole, {-lon.sin, lon.cos, 0.0}),
          turned_back(pole, {-lat.sin * lon.cos, -lat.sin * lon.sin, lat.cos}), lat.cos};
}

inline math::Vec3d normal_of(const ChartUnits& units, const math::Vec3d& p) {
  const SinCos lon = sin_cos(units, p.x), lat = sin_cos(units, p.y);
  return {lat.cos * lon.cos, lat.cos * lon.sin, lat.sin};
}

/// The chart's coordinates of a normal; `vertical` is passed on.
inline math::Vec3d chart_point(const ChartUnits& units, Pole pole, const math::Vec3d& normal,
                               double vertical) {
  const math::Vec3d n = turned(pole, normal);
  return {angle_of(units, n.y, n.x), angle_of(units, n.z, std::hypot(n.x, n.y)), vertical};
}

/// From one chart to another.
inline math::Vec3d between_charts(const ChartUnits& units, Pole from, Pole to,
                                  const math::Vec3d& p) {
  return from == to ? p : chart_point(units, to, turned_back(from, normal_of(units, p)), p.z);
}

/// The true directions east and north at a normal; at a pole those of longitude 0.
struct EastNorth {
  math::Vec3d east, north;
};
inline EastNorth east_north(const math::Vec3d& normal) {
  const double across = std::hypot(normal.x, normal.y);
  const double c = across > 0 ? normal.x / across : 1.0, s = across > 0 ? normal.y / across : 0.0;
  return {{-s, c, 0.0}, {-normal.z * c, -normal.z * s, across}};
}

/// WGS84 (National Imagery and Mapping Agency TR8350.2, 2000, table 3.1).
inline constexpr double equatorial_radius = 6378137.0; ///< metres
inline constexpr double flattening = 1 / 298.257223563;
inline constexpr double eccentricity_squared = flattening * (2 - flattening);

/// The ellipsoid's radii of curvature, metres, where the sine of the latitude is this: across the
/// meridian (N) and along it (M). At a pole they are equal.
struct Radii {
  double across, along;
};
inline Radii radii(double sin_latitude) {
  const double w2 = 1 - eccentricity_squared * sin_latitude * sin_latitude, w = std::sqrt(w2);
  return {equatorial_radius / w, equatorial_radius * (1 - eccentricity_squared) / (w2 * w)};
}

/// How a point moves on a chart, in chart units per second, that moves east, north and up at
/// `velocity` metres per second:
///
///   d lon/dt = east / ((N + h) cos lat)     d lat/dt = north / (M + h)     dh/dt = up
///
/// (Snyder, Map projections - a working manual, USGS 1395, 1987, section 4), which is
/// dn/dt = east/(N + h) e + north/(M + h) n, regular at the poles. `velocity` is in the chart's own
/// east and north: on a turned chart they are first taken to the true ones, where the radii are.
inline math::Vec3d chart_rates(const ChartUnits& units, Pole pole, const math::Vec3d& p,
                               const math::Vec3d& velocity) {
  const double h = p.z * units.up_per_unit(), per_unit = units.radians_per_unit();
  const double up = velocity.z / units.up_per_unit();
  if (pole == Pole::none) {
    const SinCos lat = sin_cos(units, p.y);
    const Radii r = radii(lat.sin);
    return {velocity.x / ((r.across + h) * lat.cos * per_unit),
            velocity.y / ((r.along + h) * per_unit), up};
  }
  const ChartPlace place = place_of(units, pole, p);
  const EastNorth axes = east_north(place.normal);
  const math::Vec3d v = velocity.x * place.east + velocity.y * place.north;
  const Radii r = radii(place.normal.z);
  const math::Vec3d dn = (dot(v, axes.east) / (r.across + h)) * axes.east +
                         (dot(v, axes.north) / (r.along + h)) * axes.north;
  return {dot(dn, place.east) / (place.cos_latitude * per_unit), dot(dn, place.north) / per_unit,
          up};
}

/// A small displacement (or a rate) on a chart at p, in metres along the chart's east, north and
/// up: the inverse of chart_rates.
inline math::Vec3d chart_metres(const ChartUnits& units, Pole pole, const math::Vec3d& p,
                                const math::Vec3d& d) {
  const double h = p.z * units.up_per_unit(), per_unit = units.radians_per_unit();
  const double up = d.z * units.up_per_unit();
  if (pole == Pole::none) {
    const SinCos lat = sin_cos(units, p.y);
    const Radii r = radii(lat.sin);
    return {d.x * ((r.across + h) * lat.cos * per_unit), d.y * ((r.along + h) * per_unit), up};
  }
  const ChartPlace place = place_of(units, pole, p);
  const EastNorth axes = east_north(place.normal);
  const math::Vec3d dn =
      (d.x * per_unit * place.cos_latitude) * place.east + (d.y * per_unit) * place.north;
  const Radii r = radii(place.normal.z);
  const math::Vec3d v = ((r.across + h) * dot(dn, axes.east)) * axes.east +
                        ((r.along + h) * dot(dn, axes.north)) * axes.north;
  return {dot(v, place.east), dot(v, place.north), up};
}

/// The longitude of the same meridian in [west, west + turn); untouched, to the bit, if it lies
/// there. NaN and infinite ones become NaN.
inline double longitude_from(double west, const ChartUnits& units, double longitude) {
  const double turn = units.turn();
  if (longitude >= west && longitude < west + turn)
    return longitude;
  double out = longitude - turn * std::floor((longitude - west) / turn);
  if (out >= west + turn) // by rounding
    out -= turn;
  return out < west ? west : out;
}

} // namespace insitu::geo
