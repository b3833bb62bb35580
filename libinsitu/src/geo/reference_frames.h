#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geo/chart.h"
#include "math/vec.h"

namespace insitu::geo {

enum class FrameKind { cartesian, geocentric, geodetic, enu, utm };

/// What the three numbers of a point mean. All but cartesian are on the WGS84 ellipsoid, in metres
/// and degrees (geodetic: in radians or kilometres if so said); a vertical number is a height above
/// the ellipsoid, or a depth below it if depth_down.
///
///   cartesian   x, y, z of the solver, with no place on Earth
///   geocentric  x, y, z from the Earth's centre: x through longitude 0 on the equator, z through
///   the
///               north pole (ECEF)
///   geodetic    longitude, latitude, height
///   enu         metres east, north and up from an origin, in the plane that touches there
///   utm         easting, northing, height, in a zone of universal transverse Mercator
struct Frame {
  FrameKind kind = FrameKind::cartesian;
  bool depth_down = false;            // geodetic, utm
  bool radians = false;               // geodetic: longitude, latitude
  bool kilometres = false;            // geodetic: height
  double longitude = 0, latitude = 0; // enu: the origin, degrees
  double height = 0;                  // enu: the origin, metres
  int zone = 0;                       // utm: 1 to 60
  bool north = true;                  // utm: false puts 10,000,000 m on the equator

  bool operator==(const Frame&) const = default;

  static Frame cartesian() { return {}; }
  static Frame geocentric();
  static Frame geodetic(bool depth_down = false);
  static Frame geodetic(const ChartUnits& units);
  static Frame enu(double longitude, double latitude, double height = 0);
  static Frame utm(int zone, bool north, bool depth_down = false);
  /// By the zone's name: "33N", "7 S". Band letters other than N and S are refused: "33S" could
  /// mean band S, which is in the north, so the error says what to write.
  static Frame utm(std::string_view zone);
};

/// The frame as an analyst writes it: "geodetic (depth down)", "enu [11.5, 48.1, 520]", "utm 33N".
std::string describe(const Frame& frame);

/// Throws core::Error (INSITU_ERROR_ARGUMENT) naming the number that is out of range (zone,
/// origin).
void validate(const Frame& frame);

/// Converts points from one frame to another; `out` has as many items as `in` and may be the same
/// memory. Equal frames give equal numbers. Longitudes come out in [-180, 180] and may go in within
/// [-540, 540] (degrees, or as many radians); depth 0 comes out as height 0 exactly. At a pole,
/// where every longitude is right, the answer is some longitude.
///
/// Error: below 10 nm for points within 5,000 km of the surface (GeographicLib's Geocentric states
/// 7 nm); utm is the 6th-order series of Krueger, which keeps 5 nm up to 3,900 km from the central
/// meridian (Karney, Transverse Mercator with an accuracy of a few nanometers, J. Geodesy 85,
/// 2011), and points further away are refused.
///
/// Throws core::Error (INSITU_ERROR_ARGUMENT): cartesian against a frame on Earth; a number that is
/// not finite or out of range, with its value and the point's index. `out` is then written in part.
void convert(const Frame& from, const Frame& to, std::span<const math::Vec3d> in,
             std::span<math::Vec3d> out);
std::vector<math::Vec3d> convert(const Frame& from, const Frame& to,
                                 std::span<const math::Vec3d> in);

/// To and from geocentric, the meeting point of all frames on Earth.
void to_geocentric(const Frame& from, std::span<const math::Vec3d> in, std::span<math::Vec3d> out);
void from_geocentric(const Frame& to, std::span<const math::Vec3d> in, std::span<math::Vec3d> out);

} // namespace insitu::geo
