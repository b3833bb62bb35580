#include "scene/earth/reference_frames.h"

#include <cmath>
#include <vector>

#include "core/caller_struct.h"
#include "geo/reference_frames.h"

namespace insitu::scene {

insitu_frame to_api(const FrameOfReference& frame, const insitu_frame& mesh) {
  using Kind = FrameOfReference::Kind;
  insitu_frame out = insitu_frame_default();
  switch (frame.kind) {
  case Kind::mesh:
    return mesh;
  case Kind::cartesian:
    break;
  case Kind::geocentric:
    out.kind = INSITU_FRAME_GEOCENTRIC;
    break;
  case Kind::geodetic:
    out.kind = INSITU_FRAME_GEODETIC;
    out.vertical = frame.depth ? INSITU_DOWN : INSITU_UP;
    break;
  case Kind::east_north_up:
    out.kind = INSITU_FRAME_ENU;
    out.origin[0] = frame.longitude;
    out.origin[1] = frame.latitude;
    out.origin[2] = frame.height;
    break;
  case Kind::utm:
    out.kind = INSITU_FRAME_UTM;
    out.utm_zone = frame.zone;
    out.utm_north = frame.north;
    break;
  }
  return out;
}

geo::Frame to_geo(const insitu_frame& f) {
  const auto check = [](const char* what, int value, const char* names) {
    if (value != 0 && value != 1)
      throw core::Error(INSITU_ERROR_ARGUMENT, std::string("frame: unknown ") + what + " " +
                                                   std::to_string(value) + ", " + names +
                                                   " expected");
  };
  check("angle", int(f.angle), "INSITU_DEGREES or INSITU_RADIANS");
  check("length", int(f.length), "INSITU_METRES or INSITU_KILOMETRES");
  check("vertical", int(f.vertical), "INSITU_UP or INSITU_DOWN");
  const bool geodetic = f.kind == INSITU_FRAME_GEODETIC, depth = f.vertical == INSITU_DOWN;
  if (!geodetic && (f.angle != INSITU_DEGREES || f.length != INSITU_METRES))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "frame: radians and kilometres are for geodetic frames alone");
  if (depth && !geodetic && f.kind != INSITU_FRAME_UTM)
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "frame: depths (INSITU_DOWN) are for geodetic and UTM frames");
  switch (f.kind) {
  case INSITU_FRAME_CARTESIAN:
    return geo::Frame::cartesian();
  case INSITU_FRAME_GEOCENTRIC:
    return geo::Frame::geocentric();
  case INSITU_FRAME_GEODETIC:
    return geo::Frame::geodetic(
        geo::ChartUnits{f.angle == INSITU_RADIANS, f.length == INSITU_KILOMETRES, depth});
  case INSITU_FRAME_ENU:
    return geo::Frame::enu(f.origin[0], f.origin[1], f.origin[2]);
  case INSITU_FRAME_UTM:
    return geo::Frame::utm(f.utm_zone, f.utm_north != 0, depth);
  }
  throw core::Error(INSITU_ERROR_ARGUMENT, "unknown frame " + std::to_string(int(f.kind)));
}

void convert_points(std::span<math::Vec3d> points, const insitu_frame& from,
                    const insitu_frame& to) {
  const geo::Frame source = to_geo(from), target = to_geo(to);
  if (source == target)
    return;
  geo::validate(source);
  // Points that are not finite lie outside every mesh; they are no error of the frame's.
  std::vector<math::Vec3d> finite;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].x) && std::isfinite(points[i].y) && std::isfinite(points[i].z)) {
      finite.push_back(points[i]);
      index.push_back(i);
    }
  geo::convert(source, target, finite, finite);
  for (std::size_t k = 0; k < index.size(); ++k)
    points[index[k]] = finite[k];
}

insitu_frame read_frame(const insitu_frame& frame) {
  const insitu_frame out = core::from_caller(&frame, "frame");
  geo::validate(to_geo(out));
  return out;
}

} // namespace insitu::scene
