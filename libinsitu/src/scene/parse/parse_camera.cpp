#include <cmath>

#include "scene/earth/geocentric_view.h"
#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

constexpr double widest_view = 170; // degrees; beyond, a perspective image is all distortion

constexpr double most_turns = 36000; // degrees along a path
constexpr std::int64_t latest_cycle = std::int64_t(1) << 53;

/// What a place on Earth needs the frame to be.
bool is_on_earth(const Cursor& cursor, const Viewpoint& view) {
  if (!view.on_earth) {
    cursor.fail("a place on Earth; only cameras of frames with 'geocentric' take one");
  }
  return view.on_earth;
}

/// `longitude`, `latitude` and the height of that name.
std::optional<math::Vec3d> parse_place(const MapReader& map, const char* height,
                                       const Interval& heights) {
  const auto longitude = map.require("longitude"), latitude = map.require("latitude");
  const auto above = map.find(height);
  const auto l = longitude ? longitude->number({-540, 540}) : std::nullopt;
  const auto b = latitude ? latitude->number({-90, 90}) : std::nullopt;
  const auto h = above ? above->number(heights) : std::optional<double>(0.0);
  return l && b && h ? std::optional(math::Vec3d{*l, *b, *h}) : std::nullopt;
}

/// `look_at`: a vector, or a place.
std::optional<math::Vec3d> parse_look_at(const Cursor& cursor, const Viewpoint& view) {
  if (!cursor.is_map()) {
    return cursor.vector();
  }
  const MapReader map(cursor, {"longitude", "latitude", "height"});
  const auto place = parse_place(map, "height", {-1e7, 1e9});
  return is_on_earth(cursor, view) && place
             ? std::optional(geocentric_place(place->x, place->y, place->z))
             : std::nullopt;
}

/// A camera at `altitude` metres above a place looks down, north up, or at what it is to look at,
/// the vertical up.
void parse_camera_place(const MapReader& map, Viewpoint& view) {
  const Cursor* given = nullptr;
  for (const char* key : {"longitude", "latitude", "altitude"}) {
    given = map.has(key) ? &map.cursor() : given;
  }
  if (!given) {
    return;
  }
  map.require("altitude");
  const auto place = parse_place(map, "altitude", {0, 1e9, true});
  if (map.has("position")) {
    given->fail("a camera has either a position or longitude, latitude and altitude");
  }
  if (!is_on_earth(*given, view) || !place) {
    return;
  }
  view.position = geocentric_place(place->x, place->y, place->z);
  const LocalAxes axes = local_axes(place->x, place->y);
  if (!map.has("look_at") && (!view.look_at || view.looks_down)) {
    view.looks_down = true;
    view.look_at = geocentric_place(place->x, place->y, 0.0);
  } else if (const auto look_at = map.find("look_at")) {
    view.look_at = parse_look_at(*look_at, view);
    view.looks_down = false;
  }
  if (!map.has("up") && !view.up_is_given && view.look_at) {
    const math::Vec3d line = *view.look_at - *view.position;
    const math::Vec3d across = math::cross(line, axes.up);
    const bool down = math::dot(across, across) <= 1e-12 * math::dot(line, line);
    view.up = down ? axes.north : axes.up;
  }
}

/// view holds what a camera gives to the keys of its path.
void parse_placement(const MapReader& map, Viewpoint& view) {
  parse_camera_place(map, view);
  if (const auto position = map.find("position")) {
    view.position = position->vector();
  }
  if (view.position) {
    for (const char* key : {"azimuth", "elevation", "zoom"}) {
      if (const auto other = map.find(key)) {
        other->fail("a camera has either a position or azimuth, elevation and zoom");
      }
    }
  }
  if (const auto look_at = map.find("look_at")) {
    view.look_at = parse_look_at(*look_at, view);
    // Of a camera with a path, its keys may have the position.
    if (!view.position && !map.has("position") && !map.has("longitude") && !map.has("path")) {
      look_at->fail("'look_at' needs a 'position'");
    }
  }
  if (const auto up = map.find("up")) {
    assign(view.up, up->vector());
    view.up_is_given = true;
    if (math::dot(view.up, view.up) == 0) {
      up->fail("a direction of some length expected");
    }
  }
  if (view.position && view.look_at) {
    const math::Vec3d view_line = *view.look_at - *view.position;
    const math::Vec3d across = math::cross(view_line, view.up);
    const double lengths = math::dot(view_line, view_line) * math::dot(view.up, view.up);
    if (math::dot(view_line, view_line) == 0) {
      map.cursor().fail("'position' and 'look_at' are the same point");
    } else if (lengths > 0 && std::isfinite(lengths) &&
               math::dot(across, across) <= 1e-12 * lengths) {
      map.cursor().fail("'up' points along the view; give another one");
    }
  }
}

void parse_viewpoint(const MapReader& map, Viewpoint& view, double most_azimuth) {
  if (const auto azimuth = map.find("azimuth")) {
    view.has_angles = true;
    assign(view.azimuth, azimuth->number({-most_azimuth, most_azimuth}));
  }
  if (const auto elevation = map.find("elevation")) {
    view.has_angles = true;
    assign(view.elevation, elevation->number({-90, 90}));
  }
  if (const auto zoom = map.find("zoom")) {
    assign(view.zoom, zoom->number({0.001, 1000}));
  }
  if (const auto fov = map.find("fov")) {
    assign(view.fov, fov->number({0, widest_view, true}));
  }
  parse_placement(map, view);
}

void parse_path(const Cursor& cursor, Camera& camera) {
  const auto items = cursor.items();
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    CameraKey key{camera, 0};
    const MapReader map(item, {"cycle", "time", "azimuth", "elevation", "zoom", "position",
                               "look_at", "up", "fov", "longitude", "latitude", "altitude"});
    const auto cycle = map.find("cycle"), time = map.find("time");
    if (map && bool(cycle) == bool(time)) {
      item.fail("a key of a path has a 'cycle' or a 'time'");
    } else if (cycle) {
      assign(key.at, cycle->integer(-latest_cycle, latest_cycle));
    } else if (time) {
      assign(key.at, time->number());
    }
    parse_viewpoint(map, key, most_turns);
    if (map && key.look_at && !key.position && !map.has("look_at")) {
      item.fail("the camera's 'look_at' needs a 'position'");
    }
    if (camera.path.empty()) {
      camera.path_by_time = time.has_value();
    } else if (map) {
      const CameraKey& before = camera.path.back();
      if (camera.path_by_time != time.has_value()) {
        item.fail("the keys of a path have all a 'cycle' or all a 'time'");
      } else if (key.at <= before.at) {
        item.fail(std::string(camera.path_by_time ? "'time'" : "'cycle'") +
                  " must be above the one of the key before");
      }
      if (key.position.has_value() != before.position.has_value()) {
        item.fail("the keys of a path have all a position, or none has one");
      }
    }
    camera.path.push_back(key);
  }
  if (items && items->size() < 2) {
    cursor.fail("at least 2 keys expected");
  }
}

void parse_orthographic(const Cursor& cursor, Camera& camera) {
  if (cursor.is_text() && (cursor.node().text == "true" || cursor.node().text == "false")) {
    assign(camera.orthographic, cursor.boolean());
    return;
  }
  double height = 0;
  if (cursor.is_text() && !cursor.node().quoted) {
    const auto number = cursor.number(positive);
    height = number.value_or(0);
  } else {
    cursor.expected("true, false or the height of the view");
  }
  if (height > 0) {
    camera.orthographic = true;
    camera.orthographic_height = height;
  }
}

} // namespace

/// On Earth: from above the mesh's middle, north up.
Camera default_camera(bool on_earth) {
  Camera camera;
  if (on_earth) {
    camera.on_earth = true;
    camera.azimuth = -90;
    camera.elevation = 90;
  }
  return camera;
}

Camera parse_camera(const Cursor& cursor, bool on_earth) {
  Camera camera = default_camera(on_earth);
  camera.line = cursor.line();
  if (cursor.is_text()) {
    if (cursor.node().text != "auto") {
      cursor.fail("auto or a map of azimuth, elevation, zoom, position, look_at, up, fov, "
                  "orthographic, fit, orbit, path, longitude, latitude, altitude expected");
    }
    return camera;
  }
  const MapReader map(cursor, {"azimuth", "elevation", "zoom", "position", "look_at", "up", "fov",
                               "orthographic", "fit", "orbit", "path", "longitude", "latitude",
                               "altitude"});
  parse_viewpoint(map, camera, 360);
  if (const auto orthographic = map.find("orthographic")) {
    parse_orthographic(*orthographic, camera);
  }
  if (const auto fit = map.find("fit")) {
    assign(camera.fit,
           fit->choice<render::Fit>({{"sphere", render::Fit::sphere}, {"box", render::Fit::box}}));
  }
  if (const auto orbit = map.find("orbit")) {
    const MapReader steps(*orbit, {"azimuth_per_frame"});
    if (const auto step = steps.require("azimuth_per_frame")) {
      assign(camera.orbit_azimuth_per_frame, step->number({-360, 360}));
    }
  }
  if (const auto path = map.find("path")) {
    parse_path(*path, camera);
    if (map.has("orbit")) {
      path->fail("a camera has either a path or an orbit");
    }
  }
  return camera;
}

std::vector<NamedCamera> parse_cameras(const Cursor& cursor, bool on_earth) {
  std::vector<NamedCamera> cameras;
  if (!cursor.is_map() || cursor.node().entries.empty()) {
    cursor.expected("a map of names and cameras");
    return cameras;
  }
  for (const YamlNode::Entry& entry : cursor.node().entries) {
    const Cursor item(*entry.value, cursor.path() + "." + entry.key, cursor.problems());
    if (!fits_file_name(entry.key)) {
      item.fail(quote(entry.key) + " cannot stand in a file's name");
    }
    for (const NamedCamera& other : cameras) {
      if (other.name == entry.key) {
        item.fail("the camera " + quote(entry.key) + " is given twice");
      }
    }
    cameras.push_back({entry.key, parse_camera(item, on_earth)});
  }
  return cameras;
}

} // namespace insitu::scene
