#include <cmath>

#include "scene/parse_parts.h"

namespace insitu::scene {
namespace {

constexpr double widest_view = 170; // degrees; beyond, a perspective image is all distortion

void parse_placement(const MapReader& map, Camera& camera) {
  if (const auto position = map.find("position")) {
    camera.position = position->vector();
    for (const char* key : {"azimuth", "elevation", "zoom"}) {
      if (const auto other = map.find(key)) {
        other->fail("a camera has either a position or azimuth, elevation and zoom");
      }
    }
  }
  if (const auto look_at = map.find("look_at")) {
    camera.look_at = look_at->vector();
    if (!map.has("position")) {
      look_at->fail("'look_at' needs a 'position'");
    }
  }
  if (const auto up = map.find("up")) {
    assign(camera.up, up->vector());
    if (math::dot(camera.up, camera.up) == 0) {
      up->fail("a direction of some length expected");
    }
  }
  if (camera.position && camera.look_at) {
    const math::Vec3d view = *camera.look_at - *camera.position;
    const math::Vec3d across = math::cross(view, camera.up);
    const double lengths = math::dot(view, view) * math::dot(camera.up, camera.up);
    if (math::dot(view, view) == 0) {
      map.cursor().fail("'position' and 'look_at' are the same point");
    } else if (lengths > 0 && std::isfinite(lengths) &&
               math::dot(across, across) <= 1e-12 * lengths) {
      map.cursor().fail("'up' points along the view; give another one");
    }
  }
}

} // namespace

Camera parse_camera(const Cursor& cursor) {
  Camera camera;
  camera.line = cursor.line();
  if (cursor.is_text()) {
    if (cursor.node().text != "auto") {
      cursor.fail(
          "camera paths are not available in this version; auto or a map of azimuth, elevation, "
          "zoom, position, look_at, up, fov, orbit expected");
    }
    return camera;
  }
  const MapReader map(
      cursor, {"azimuth", "elevation", "zoom", "position", "look_at", "up", "fov", "orbit"});
  if (const auto azimuth = map.find("azimuth")) {
    assign(camera.azimuth, azimuth->number({-360, 360}));
  }
  if (const auto elevation = map.find("elevation")) {
    assign(camera.elevation, elevation->number({-90, 90}));
  }
  if (const auto zoom = map.find("zoom")) {
    assign(camera.zoom, zoom->number({0.001, 1000}));
  }
  if (const auto fov = map.find("fov")) {
    assign(camera.fov, fov->number({0, widest_view, true}));
  }
  parse_placement(map, camera);
  if (const auto orbit = map.find("orbit")) {
    const MapReader steps(*orbit, {"azimuth_per_frame"});
    if (const auto step = steps.require("azimuth_per_frame")) {
      assign(camera.orbit_azimuth_per_frame, step->number({-360, 360}));
    }
  }
  return camera;
}

} // namespace insitu::scene
