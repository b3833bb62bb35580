#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

std::vector<OpacityPoint> parse_opacity(const Cursor& cursor) {
  std::vector<OpacityPoint> points;
  const auto items = cursor.items();
  if (items && items->empty()) {
    cursor.fail("at least one [value, opacity] expected");
  }
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    const auto pair = item.numbers(2);
    if (!pair) {
      continue;
    }
    if ((*pair)[1] < 0 || (*pair)[1] > 1) {
      item.fail("an opacity from 0 to 1 expected as the second number");
    } else if (!points.empty() && (*pair)[0] < points.back().value) {
      item.fail("the values must not decrease");
    } else {
      points.push_back({(*pair)[0], (*pair)[1]});
    }
  }
  return points;
}

} // namespace

Volume parse_volume(const Cursor& cursor, const ParseContext& context) {
  Volume volume;
  volume.line = cursor.line();
  const MapReader map(cursor, {"field", "component", "colors", "range", "scale", "below", "above",
                               "nan", "opacity", "nan_opacity", "unit_distance", "smooth",
                               "preintegrated", "shading", "tolerance", "culling"});
  if (const auto field = map.require("field")) {
    assign(volume.field, parse_name(*field));
  }
  if (const auto component = map.find("component")) {
    volume.component = parse_component(*component);
  }
  volume.colors = parse_color_map(map, context);
  if (const auto opacity = map.find("opacity")) {
    volume.opacity = parse_opacity(*opacity);
  }
  if (const auto opacity = map.find("nan_opacity")) {
    assign(volume.nan_opacity, opacity->number({0, 1}));
  }
  if (const auto smooth = map.find("smooth")) {
    assign(volume.smooth, smooth->boolean());
  }
  if (const auto distance = map.find("unit_distance")) {
    assign(volume.unit_distance, distance->number(positive));
  }
  if (const auto preintegrated = map.find("preintegrated")) {
    volume.preintegrated = preintegrated->boolean();
  }
  if (const auto shading = map.find("shading")) {
    assign(volume.shading, shading->boolean());
  }
  if (const auto tolerance = map.find("tolerance")) {
    assign(volume.tolerance, tolerance->number(positive));
    if (volume.preintegrated.value_or(false)) {
      tolerance->fail("pre-integration takes even steps, a tolerance makes them uneven; one of "
                      "them expected");
    }
  }
  if (const auto culling = map.find("culling")) {
    assign(volume.culling, culling->choice<render::Culling>({{"never", render::Culling::never},
                                                             {"always", render::Culling::always}}));
  }
  return volume;
}

} // namespace insitu::scene
