#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

constexpr std::size_t most_lights = 64;
constexpr std::size_t most_clips = 64;
constexpr std::int64_t most_occlusion_samples = 65536;

/// The map's only key of `kinds`; others are options. Notes a problem where there is none or a
/// second one.
int only_kind(const MapReader& map, const std::vector<const char*>& kinds, const char* what) {
  int found = -1;
  std::string all;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    all += (i == 0 ? "'" : i + 1 < kinds.size() ? ", '" : " or '") + std::string(kinds[i]) + "'";
    if (!map.has(kinds[i])) {
      continue;
    }
    if (found >= 0) {
      map.cursor().fail(std::string(what) + " has one of " + "'" +
                        kinds[static_cast<std::size_t>(found)] + "' and '" + kinds[i] +
                        "', not both");
      return -1;
    }
    found = static_cast<int>(i);
  }
  if (map && found < 0) {
    map.cursor().fail(std::string(what) + " needs " + all);
  }
  return found;
}

/// A vector that is not zero.
std::optional<math::Vec3d> parse_direction(const Cursor& cursor) {
  const auto vector = cursor.vector();
  if (vector && vector->x == 0 && vector->y == 0 && vector->z == 0) {
    cursor.fail("a direction is not zero");
    return std::nullopt;
  }
  return vector;
}

/// `true`, since a light or nothing is what the key says.
void parse_true(const Cursor& cursor) {
  const auto is = cursor.boolean();
  if (is && !*is) {
    cursor.fail("true expected; leave the light out instead");
  }
}

render::Light parse_light(const Cursor& cursor) {
  render::Light light;
  const MapReader map(cursor, {"head", "directional", "point", "dome", "color", "intensity"});
  const std::vector<const char*> kinds{"head", "directional", "point", "dome"};
  const int kind = only_kind(map, kinds, "a light");
  if (kind >= 0) {
    light.kind = static_cast<render::Light::Kind>(kind);
    const Cursor value = *map.find(kinds[static_cast<std::size_t>(kind)]);
    if (light.kind == render::Light::Kind::directional) {
      assign(light.vector, parse_direction(value));
    } else if (light.kind == render::Light::Kind::point) {
      assign(light.vector, value.vector());
    } else {
      parse_true(value);
    }
  }
  render::Color color = render::linear_of_srgb(1, 1, 1);
  if (const auto given = map.find("color")) {
    color = parse_color(*given, color);
  }
  double intensity = 1; // a factor on linear light
  if (const auto given = map.find("intensity")) {
    assign(intensity, given->number({0, 1e30}));
  }
  light.color = float(intensity) * color;
  return light;
}

void parse_plane(const Cursor& cursor, render::Clip& clip) {
  clip.kind = render::Clip::Kind::plane;
  const MapReader map(cursor, {"point", "normal"});
  if (const auto point = map.require("point")) {
    assign(clip.point, point->vector());
  }
  if (const auto normal = map.require("normal")) {
    assign(clip.vector, parse_direction(*normal));
  }
}

void parse_keep(const MapReader& map, render::Clip& clip) {
  if (const auto keep = map.find("keep")) {
    assign(clip.keep_inside, keep->choice<bool>({{"inside", true}, {"outside", false}}));
  }
}

void parse_box(const Cursor& cursor, render::Clip& clip) {
  clip.kind = render::Clip::Kind::box;
  const MapReader map(cursor, {"min", "max", "keep"});
  const auto low = map.require("min"), high = map.require("max");
  if (low && high) {
    const auto from = low->vector(), to = high->vector();
    if (from && to) {
      clip.point = *from;
      clip.vector = *to;
      if (from->x > to->x || from->y > to->y || from->z > to->z) {
        cursor.fail("min is above max");
      }
    }
  }
  parse_keep(map, clip);
}

void parse_sphere(const Cursor& cursor, render::Clip& clip) {
  clip.kind = render::Clip::Kind::sphere;
  const MapReader map(cursor, {"center", "radius", "keep"});
  if (const auto center = map.require("center")) {
    assign(clip.point, center->vector());
  }
  if (const auto radius = map.require("radius")) {
    assign(clip.radius, radius->number(positive));
  }
  parse_keep(map, clip);
}

render::Clip parse_clip(const Cursor& cursor) {
  render::Clip clip;
  const MapReader map(cursor, {"plane", "box", "sphere"});
  switch (only_kind(map, {"plane", "box", "sphere"}, "a clip")) {
  case 0:
    parse_plane(*map.find("plane"), clip);
    break;
  case 1:
    parse_box(*map.find("box"), clip);
    break;
  case 2:
    parse_sphere(*map.find("sphere"), clip);
    break;
  default:
    break;
  }
  return clip;
}

template <class T, class Parse>
std::vector<T> parse_list(const Cursor& cursor, std::size_t most, Parse&& parse) {
  std::vector<T> list;
  const auto items = cursor.items();
  if (items && items->size() > most) {
    cursor.fail(std::to_string(items->size()) + " items, more than " + std::to_string(most));
    return list;
  }
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    list.push_back(parse(item));
  }
  return list;
}

} // namespace

std::vector<render::Light> parse_lights(const Cursor& cursor) {
  return parse_list<render::Light>(cursor, most_lights, parse_light);
}

Occlusion parse_occlusion(const Cursor& cursor) {
  Occlusion occlusion;
  const MapReader map(cursor, {"samples", "distance"});
  if (const auto samples = map.find("samples")) {
    if (const auto count = samples->integer(1, most_occlusion_samples)) {
      occlusion.samples = static_cast<int>(*count);
    }
  }
  if (const auto distance = map.find("distance")) {
    assign(occlusion.distance, distance->number(positive));
  }
  return occlusion;
}

std::vector<render::Clip> parse_clips(const Cursor& cursor) {
  return parse_list<render::Clip>(cursor, most_clips, parse_clip);
}

} // namespace insitu::scene
