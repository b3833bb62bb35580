#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/TransverseMercator.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "core/status.h"
#include "geo/reference_frames.h"

namespace insitu::geo {

namespace {

using GeographicLib::Geocentric;
using GeographicLib::TransverseMercator;
using math::Vec3d;

constexpr double false_easting = 500e3;
constexpr double false_northing_south = 10000e3;
constexpr double series_reach = 3900e3;   // from the central meridian, metres
constexpr double pole_northing = 9997965; // rounded up: 0.9996 quarter meridians, metres

[[noreturn]] void refuse(const Frame& frame, const char* name, double value, std::size_t index,
                         const std::string& why) {
  char text[32];
  const std::string digits(text, std::to_chars(text, text + sizeof text, value).ptr);
  throw core::Error(INSITU_ERROR_ARGUMENT, describe(frame) + " point " + std::to_string(index) +
                                               ": " + name + " " + digits + " " + why);
}

void require_finite(const Frame& frame, const Vec3d& p, std::size_t index) {
  static constexpr const char* names[][3] = {{"x", "y", "z"},
                                             {"x", "y", "z"},
                                             {"longitude", "latitude", "height"},
                                             {"east", "north", "up"},
                                             {"easting", "northing", "height"}};
  for (int i = 0; i < 3; ++i)
    if (!std::isfinite(p[i]))
      refuse(frame, names[int(frame.kind)][i], p[i], index, "is not finite");
}

/// A point of a geodetic frame, in its units.
void require_angles(const Frame& frame, const Vec3d& p, std::size_t index) {
  if (!(std::abs(p.y) <= (frame.radians ? std::numbers::pi / 2 : 90.0))) {
    refuse(frame, "latitude", p.y, index,
           frame.radians ? "is not in [-pi/2, pi/2] (points are longitude, latitude, height)"
                         : "is not in [-90, 90] (points are longitude, latitude, height)");
  }
  if (!(std::abs(p.x) <= (frame.radians ? 3 * std::numbers::pi : 540.0))) {
    refuse(frame, "longitude", p.x, index,
           frame.radians ? "is not in [-3 pi, 3 pi]" : "is not in [-540, 540]");
  }
}

double vertical(const Frame& frame, double value) {
  return frame.depth_down ? -value : value;
}

/// A frame's angle in degrees; the quarter turn of a pole exactly.
double angle_to_degrees(const Frame& frame, double angle) {
  constexpr double pole = std::numbers::pi / 2;
  return !frame.radians            ? angle
         : std::abs(angle) == pole ? std::copysign(90.0, angle)
                                   : angle * (180 / std::numbers::pi);
}

double angle_from_degrees(const Frame& frame, double angle) {
  return !frame.radians          ? angle
         : std::abs(angle) == 90 ? std::copysign(std::numbers::pi / 2, angle)
                                 : angle * (std::numbers::pi / 180);
}

double central_meridian(const Frame& frame) {
  return 6.0 * frame.zone - 183.0;
}

/// Longitude, latitude, height to easting, northing, height.
Vec3d to_utm(const Frame& to, const Vec3d& p, std::size_t index) {
  // Every longitude is right at a pole.
  const double longitude = std::abs(p.y) == 90 ? central_meridian(to) : p.x;
  Vec3d out;
  TransverseMercator::UTM().Forward(central_meridian(to), p.y, longitude, out.x, out.y);
  // More than 90 degrees away, x may be small again: beyond the pole.
  const double turn = std::remainder(longitude - central_meridian(to), 360.0);
  if (std::abs(out.x) > series_reach || std::abs(turn) > 90) {
    refuse(to, "longitude", p.x, index,
           "is too far from the zone's central meridian, " +
               std::to_string(int(central_meridian(to))));
  }
  out.x += false_easting;
  out.y += to.north ? 0.0 : false_northing_south;
  out.z = vertical(to, p.z);
  return out;
}

Vec3d from_utm(const Frame& from, const Vec3d& p, std::size_t index) {
  const double x = p.x - false_easting;
  const double y = p.y - (from.north ? 0.0 : false_northing_south);
  if (std::abs(x) > series_reach)
    refuse(from, "easting", p.x, index, "is more than 3,900 km from the zone's central meridian");
  if (std::abs(y) > pole_northing)
    refuse(from, "northing", p.y, index, "lies beyond a pole");
  Vec3d out;
  TransverseMercator::UTM().Reverse(central_meridian(from), x, y, out.y, out.x);
  out.z = vertical(from, p.z);
  return out;
}

/// Converts one point at a time; made once per batch, so that an origin's rotation is too.
class Converter {
public:
  explicit Converter(const Frame& frame) : frame_(frame) {
    validate(frame);
    if (frame.kind == FrameKind::enu) {
      std::vector<double> axes(9); // row by row; its columns are east, north and up
      Geocentric::WGS84().Forward(frame.latitude, frame.longitude, frame.height, origin_.x,
                                  origin_.y, origin_.z, axes);
      east_ = {axes[0], axes[3], axes[6]};
      north_ = {axes[1], axes[4], axes[7]};
      up_ = {axes[2], axes[5], axes[8]};
    }
  }

  bool is_chart() const {
    return frame_.kind == FrameKind::geodetic || frame_.kind == FrameKind::utm;
  }

  /// Of a frame that is a chart: to longitude, latitude, height.
  Vec3d to_degrees(const Vec3d& p, std::size_t index) const {
    require_finite(frame_, p, index);
    if (frame_.kind == FrameKind::utm)
      return from_utm(frame_, p, index);
    require_angles(frame_, p, index);
    return {angle_to_degrees(frame_, p.x), angle_to_degrees(frame_, p.y),
            vertical(frame_, frame_.kilometres ? p.z * 1000 : p.z)};
  }

  Vec3d from_degrees(const Vec3d& p, std::size_t index) const {
    if (frame_.kind == FrameKind::utm)
      return to_utm(frame_, p, index);
    const double longitude = std::abs(p.x) > 180 ? std::remainder(p.x, 360.0) : p.x;
    return {angle_from_degrees(frame_, longitude), angle_from_degrees(frame_, p.y),
            vertical(frame_, frame_.kilometres ? p.z / 1000 : p.z)};
  }

  Vec3d to_geocentric(const Vec3d& p, std::size_t index) const {
    if (is_chart()) {
      const Vec3d d = to_degrees(p, index);
      Vec3d out;
      Geocentric::WGS84().Forward(d.y, d.x, d.z, out.x, out.y, out.z);
      return out;
    }
    require_finite(frame_, p, index);
    return frame_.kind == FrameKind::enu ? origin_ + p.x * east_ + p.y * north_ + p.z * up_ : p;
  }

  Vec3d from_geocentric(const Vec3d& p, std::size_t index) const {
    if (frame_.kind == FrameKind::geocentric)
      return p;
    if (frame_.kind == FrameKind::enu) {
      const Vec3d d = p - origin_;
      return {dot(east_, d), dot(north_, d), dot(up_, d)};
    }
    Vec3d d;
    Geocentric::WGS84().Reverse(p.x, p.y, p.z, d.y, d.x, d.z);
    return from_degrees(d, index);
  }

private:
  Frame frame_;
  Vec3d origin_, east_, north_, up_;
};

void check_sizes(std::size_t in, std::size_t out) {
  if (in != out) {
    throw core::Error(INSITU_ERROR_ARGUMENT, "points: " + std::to_string(in) + " in, room for " +
                                                 std::to_string(out) + " out");
  }
}

} // namespace

void convert(const Frame& from, const Frame& to, std::span<const Vec3d> in, std::span<Vec3d> out) {
  check_sizes(in.size(), out.size());
  if (from == to) {
    std::copy(in.begin(), in.end(), out.begin());
    return;
  }
  if (from.kind == FrameKind::cartesian || to.kind == FrameKind::cartesian) {
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "points in " + describe(from) + " cannot be converted to " + describe(to) +
                          ": a cartesian frame has no place on Earth; give the mesh or the points "
                          "the frame that their numbers are in (geocentric, geodetic, enu or utm)");
  }
  const Converter source(from), target(to);
  // Charts meet in degrees, without the way through the Earth's centre and its rounding.
  const bool charts = source.is_chart() && target.is_chart();
  for (std::size_t i = 0; i < in.size(); ++i) {
    out[i] = charts ? target.from_degrees(source.to_degrees(in[i], i), i)
                    : target.from_geocentric(source.to_geocentric(in[i], i), i);
  }
}

std::vector<Vec3d> convert(const Frame& from, const Frame& to, std::span<const Vec3d> in) {
  std::vector<Vec3d> out(in.size());
  convert(from, to, in, out);
  return out;
}

void to_geocentric(const Frame& from, std::span<const Vec3d> in, std::span<Vec3d> out) {
  convert(from, Frame::geocentric(), in, out);
}

void from_geocentric(const Frame& to, std::span<const Vec3d> in, std::span<Vec3d> out) {
  convert(Frame::geocentric(), to, in, out);
}

} // namespace insitu::geo
