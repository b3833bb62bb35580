#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

constexpr Interval longitudes{-360, 360};
constexpr Interval latitudes{-90, 90};

/// "33N" as zone and hemisphere.
void parse_utm_zone(const Cursor& cursor, FrameOfReference& frame) {
  const std::string text = cursor.is_text() ? cursor.node().text : std::string();
  const std::size_t digits = text.size() < 2 ? 0 : text.size() - 1;
  int zone = 0;
  bool valid = digits == 1 || digits == 2;
  for (std::size_t i = 0; valid && i < digits; ++i) {
    valid = text[i] >= '0' && text[i] <= '9';
    zone = zone * 10 + (text[i] - '0');
  }
  if (!valid || zone < 1 || zone > 60 || (text.back() != 'N' && text.back() != 'S')) {
    cursor.expected("a UTM zone from 1 to 60 and its hemisphere, such as 33N or 56S,");
    return;
  }
  frame.kind = FrameOfReference::Kind::utm;
  frame.zone = zone;
  frame.north = text.back() == 'N';
}

void parse_origin(const Cursor& cursor, FrameOfReference& frame) {
  const auto origin = cursor.vector();
  if (!origin) {
    return;
  }
  if (origin->x < longitudes.low || origin->x > longitudes.high || origin->y < latitudes.low ||
      origin->y > latitudes.high) {
    cursor.fail("a longitude from -360 to 360 and a latitude from -90 to 90 degrees expected");
    return;
  }
  frame.kind = FrameOfReference::Kind::east_north_up;
  frame.longitude = origin->x;
  frame.latitude = origin->y;
  frame.height = origin->z;
}

/// Reads one entry of the shape's map into a vector.
void parse_vector(const MapReader& map, const char* key, math::Vec3d& out) {
  if (const auto value = map.require(key)) {
    assign(out, value->vector());
  }
}

void parse_count(const MapReader& map, std::int64_t& out) {
  if (const auto value = map.require("count")) {
    assign(out, value->integer(1, most_points));
  }
}

template <std::size_t n>
void parse_counts(const MapReader& map, std::array<std::int64_t, n>& out) {
  const auto value = map.require("counts");
  const auto items = value ? value->items() : std::nullopt;
  if (!items) {
    return;
  }
  if (items->size() != n) {
    value->expected("a list of " + std::to_string(n) + " integers");
    return;
  }
  std::int64_t product = 1;
  for (std::size_t i = 0; i < n; ++i) {
    assign(out[i], (*items)[i].integer(1, most_points));
    if (product > most_points / out[i]) {
      value->fail("the counts make more than " + std::to_string(most_points) + " points");
      out.fill(1);
      return;
    }
    product *= out[i];
  }
}

PointSource parse_list(const Cursor& cursor) {
  PointList list;
  const auto items = cursor.items();
  if (items && items->empty()) {
    cursor.fail("at least one point expected");
  }
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    if (const auto point = item.vector()) {
      list.points.push_back(*point);
    }
  }
  return list;
}

template <class Segment>
PointSource parse_segment(const Cursor& cursor) {
  Segment segment;
  const MapReader map(cursor, {"from", "to", "count"});
  parse_vector(map, "from", segment.from);
  parse_vector(map, "to", segment.to);
  parse_count(map, segment.count);
  return segment;
}

PointSource parse_plane(const Cursor& cursor) {
  Plane plane;
  const MapReader map(cursor, {"origin", "u", "v", "counts"});
  parse_vector(map, "origin", plane.origin);
  parse_vector(map, "u", plane.u);
  parse_vector(map, "v", plane.v);
  parse_counts(map, plane.counts);
  return plane;
}

PointSource parse_box(const Cursor& cursor) {
  Box box;
  const MapReader map(cursor, {"min", "max", "counts"});
  parse_vector(map, "min", box.min);
  parse_vector(map, "max", box.max);
  parse_counts(map, box.counts);
  if (map.has("min") && map.has("max") &&
      (box.min.x > box.max.x || box.min.y > box.max.y || box.min.z > box.max.z)) {
    cursor.fail("'min' lies above 'max'");
  }
  return box;
}

PointSource parse_sphere(const Cursor& cursor) {
  Sphere sphere;
  const MapReader map(cursor, {"center", "radius", "count"});
  parse_vector(map, "center", sphere.center);
  if (const auto radius = map.require("radius")) {
    assign(sphere.radius, radius->number(positive));
  }
  parse_count(map, sphere.count);
  return sphere;
}

/// Numbers one by one, or in equal steps.
std::vector<double> parse_levels(const Cursor& cursor) {
  std::vector<double> levels;
  if (cursor.is_map()) {
    double from = 0, to = 0;
    std::int64_t count = 0;
    const MapReader map(cursor, {"from", "to", "count"});
    for (const auto& [key, end] : {std::pair{"from", &from}, std::pair{"to", &to}}) {
      if (const auto value = map.require(key)) {
        assign(*end, value->number());
      }
    }
    if (const auto value = map.require("count")) {
      assign(count, value->integer(2, most_levels));
    }
    for (std::int64_t i = 0; i < count; ++i) {
      const double t = static_cast<double>(i) / static_cast<double>(count - 1);
      levels.push_back((1 - t) * from + t * to);
    }
  } else if (!cursor.is_list()) {
    cursor.expected("a list of numbers, or a map of from, to and count");
  } else {
    assign(levels, cursor.numbers(0));
  }
  const bool descend = levels.size() > 1 && levels[1] < levels[0];
  for (std::size_t i = 1; i < levels.size(); ++i) {
    if (descend ? levels[i] >= levels[i - 1] : levels[i] <= levels[i - 1]) {
      cursor.fail("levels ascend or descend; level " + std::to_string(i) + " does not");
      break;
    }
  }
  if (levels.empty()) { // noted above
    levels.push_back(0);
  }
  return levels;
}

PointSource parse_curtain(const Cursor& cursor, const FrameOfReference& frame) {
  Curtain curtain;
  const MapReader map(cursor, {"through", "count", "levels"});
  if (frame.kind == FrameOfReference::Kind::geocentric) {
    cursor.fail("a curtain has no upright in geocentric coordinates; give it in another frame");
  }
  if (const auto through = map.require("through")) {
    for (const Cursor& item : through->items().value_or(std::vector<Cursor>{})) {
      const auto place = item.numbers(2);
      if (!place) {
        continue;
      }
      const math::Vec3d at{(*place)[0], (*place)[1], 0};
      if (!curtain.through.empty() && curtain.through.back() == at) {
        item.fail("the place before is the same");
      }
      curtain.through.push_back(at);
    }
    if (through->is_list() && through->node().items.size() < 2) {
      through->fail("at least two places expected");
    }
  }
  if (const auto count = map.require("count")) {
    assign(curtain.count, count->integer(2, most_points));
  }
  curtain.levels = {0};
  if (const auto levels = map.require("levels")) {
    curtain.levels = parse_levels(*levels);
  }
  if (curtain.count > most_points / static_cast<std::int64_t>(curtain.levels.size())) {
    cursor.fail("the stations and levels make more than " + std::to_string(most_points) +
                " points");
    curtain.count = 2;
  }
  return curtain;
}

/// Every latitude that the source names must be one.
void check_latitudes(const Cursor& cursor, const PointSource& source) {
  const auto check = [&](const math::Vec3d& point, const std::string& what) {
    if (point.y < latitudes.low || point.y > latitudes.high) {
      cursor.fail(what + " has the latitude " + std::to_string(point.y) +
                  "; from -90 to 90 degrees expected (points are longitude, latitude, height)");
    }
  };
  if (const auto* list = std::get_if<PointList>(&source)) {
    for (std::size_t i = 0; i < list->points.size(); ++i) {
      check(list->points[i], "point " + std::to_string(i));
    }
  } else if (const auto* line = std::get_if<Line>(&source)) {
    check(line->from, "'from'");
    check(line->to, "'to'");
  } else if (const auto* transect = std::get_if<Transect>(&source)) {
    check(transect->from, "'from'");
    check(transect->to, "'to'");
  } else if (const auto* box = std::get_if<Box>(&source)) {
    check(box->min, "'min'");
    check(box->max, "'max'");
  } else if (const auto* plane = std::get_if<Plane>(&source)) {
    check(plane->origin, "the corner 'origin'");
    check(plane->origin + plane->u, "the corner 'origin' + 'u'");
    check(plane->origin + plane->v, "the corner 'origin' + 'v'");
    check(plane->origin + plane->u + plane->v, "the corner 'origin' + 'u' + 'v'");
  } else if (const auto* curtain = std::get_if<Curtain>(&source)) {
    for (std::size_t i = 0; i < curtain->through.size(); ++i) {
      check(curtain->through[i], "place " + std::to_string(i));
    }
  } else if (std::holds_alternative<Sphere>(source)) {
    cursor.fail("a sphere has no meaning in longitude and latitude; give it in another frame");
  }
}

PointSource parse_shape(const Cursor& cursor, const ParseContext& context,
                        const FrameOfReference& frame) {
  const MapReader map(cursor,
                      {"points", "line", "transect", "curtain", "plane", "grid", "box", "sphere"});
  if (map && cursor.node().entries.size() != 1) {
    cursor.fail(
        "exactly one of points, line, transect, curtain, plane, grid, box, sphere expected, " +
        std::to_string(cursor.node().entries.size()) + " keys found");
    return {};
  }
  if (const auto points = map.find("points")) {
    if (points->is_map()) {
      points->expected("a list of points or a file's name");
      return {};
    }
    return parse_points(*points, context, frame);
  }
  PointSource source;
  if (const auto line = map.find("line")) {
    source = parse_segment<Line>(*line);
  } else if (const auto transect = map.find("transect")) {
    source = parse_segment<Transect>(*transect);
  } else if (const auto curtain = map.find("curtain")) {
    source = parse_curtain(*curtain, frame);
  } else if (const auto plane = map.find("plane")) {
    source = parse_plane(*plane);
  } else if (const auto grid = map.find("grid")) {
    source = parse_box(*grid);
  } else if (const auto box = map.find("box")) {
    source = parse_box(*box);
  } else if (const auto sphere = map.find("sphere")) {
    source = parse_sphere(*sphere);
  } else {
    return {};
  }
  if (frame.kind == FrameOfReference::Kind::geodetic) {
    check_latitudes(cursor, source);
  }
  return source;
}

} // namespace

FrameOfReference parse_frame_of_reference(const Cursor& cursor) {
  using Kind = FrameOfReference::Kind;
  FrameOfReference frame;
  frame.line = cursor.line();
  if (cursor.is_text()) {
    assign(frame.kind, cursor.choice<Kind>({{"mesh", Kind::mesh},
                                            {"cartesian", Kind::cartesian},
                                            {"geocentric", Kind::geocentric},
                                            {"geodetic", Kind::geodetic}}));
    return frame;
  }
  if (!cursor.is_map()) {
    cursor.expected("mesh, cartesian, geocentric, geodetic, {geodetic: depth}, {enu: [lon, lat, "
                    "height]} or {utm: 33N}");
    return frame;
  }
  const MapReader map(cursor, {"enu", "utm", "geodetic"});
  if (cursor.node().entries.size() != 1) {
    cursor.fail("exactly one of enu, utm, geodetic expected, " +
                std::to_string(cursor.node().entries.size()) + " keys found");
  } else if (const auto origin = map.find("enu")) {
    parse_origin(*origin, frame);
  } else if (const auto zone = map.find("utm")) {
    parse_utm_zone(*zone, frame);
  } else if (const auto vertical = map.find("geodetic")) {
    frame.kind = Kind::geodetic;
    assign(frame.depth, vertical->choice<bool>({{"height", false}, {"depth", true}}));
  }
  return frame;
}

PointSource parse_points(const Cursor& cursor, const ParseContext& context,
                         const FrameOfReference& frame) {
  if (cursor.is_text()) {
    PointFile file;
    if (const auto path = cursor.text()) {
      file.path = resolve_path(*path, context.base_folder);
    }
    return file;
  }
  if (cursor.is_map()) {
    return parse_shape(cursor, context, frame);
  }
  if (!cursor.is_list()) {
    cursor.expected("a file's name, a list of points, or a map of line, transect, curtain, plane, "
                    "grid, box or sphere");
    return {};
  }
  PointSource source = parse_list(cursor);
  if (frame.kind == FrameOfReference::Kind::geodetic) {
    check_latitudes(cursor, source);
  }
  return source;
}

} // namespace insitu::scene
