#include "scene/parse_parts.h"

namespace insitu::scene {
namespace {

struct NamedColor {
  const char* name;
  Color color;
};
constexpr NamedColor named_colors[] = {{"black", {0, 0, 0}},
                                       {"white", {1, 1, 1}},
                                       {"gray", {0.5, 0.5, 0.5}},
                                       {"grey", {0.5, 0.5, 0.5}},
                                       {"red", {1, 0, 0}},
                                       {"green", {0, 0.5, 0}},
                                       {"blue", {0, 0, 1}},
                                       {"yellow", {1, 1, 0}},
                                       {"cyan", {0, 1, 1}},
                                       {"magenta", {1, 0, 1}},
                                       {"orange", {1, 165 / 255.0, 0}}};

int hexadecimal_digit(char c) {
  if (c >= '0' && c <= '9') {
    return c - '0';
  }
  if (c >= 'a' && c <= 'f') {
    return c - 'a' + 10;
  }
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

std::optional<Color> hexadecimal_color(const std::string& text) {
  if (text.size() != 7 || text[0] != '#') {
    return std::nullopt;
  }
  double parts[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const int high = hexadecimal_digit(text[1 + 2 * i]);
    const int low = hexadecimal_digit(text[2 + 2 * i]);
    if (high < 0 || low < 0) {
      return std::nullopt;
    }
    parts[i] = (16 * high + low) / 255.0;
  }
  return Color{parts[0], parts[1], parts[2]};
}

Component parse_component(const Cursor& cursor) {
  Component component;
  if (cursor.is_text() && cursor.node().text == "magnitude") {
    return component;
  }
  if (cursor.is_text() && !cursor.node().text.empty() &&
      cursor.node().text.find_first_not_of("0123456789") != std::string::npos &&
      cursor.node().text[0] != '-') {
    cursor.expected("magnitude or a component's number from 0");
    return component;
  }
  if (const auto number = cursor.integer(0, 1023)) {
    component.index = static_cast<int>(*number);
  }
  return component;
}

ColorMap parse_color_map(const Cursor& cursor, const ParseContext& context) {
  ColorMap map;
  map.line = cursor.line();
  if (const auto name = cursor.text()) {
    map.name = *name;
    const bool is_file = name->find('/') != std::string::npos ||
                         (name->size() > 5 && name->compare(name->size() - 5, 5, ".json") == 0);
    map.path = is_file ? resolve_path(*name, context.base_folder) : std::string();
  }
  return map;
}

std::optional<ValueRange> parse_range(const Cursor& cursor) {
  if (cursor.is_text() && cursor.node().text == "auto") {
    return std::nullopt;
  }
  if (!cursor.is_list()) {
    cursor.expected("auto or a list of 2 numbers");
    return std::nullopt;
  }
  const auto values = cursor.numbers(2);
  if (!values) {
    return std::nullopt;
  }
  if ((*values)[0] >= (*values)[1]) {
    cursor.fail("the first number must be below the second");
    return std::nullopt;
  }
  return ValueRange{(*values)[0], (*values)[1]};
}

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

ColorBy parse_color_by(const Cursor& cursor, const ParseContext& context) {
  ColorBy by;
  const MapReader map(cursor, {"field", "component", "colors", "range"});
  if (const auto field = map.require("field")) {
    assign(by.field, parse_name(*field));
  }
  if (const auto component = map.find("component")) {
    by.component = parse_component(*component);
  }
  if (const auto colors = map.find("colors")) {
    by.colors = parse_color_map(*colors, context);
  }
  if (const auto range = map.find("range")) {
    by.range = parse_range(*range);
  }
  return by;
}

Isosurface parse_isosurface(const Cursor& cursor, const ParseContext& context) {
  Isosurface surface;
  surface.line = cursor.line();
  const MapReader map(cursor, {"field", "component", "values", "opacity", "color"});
  if (const auto field = map.require("field")) {
    assign(surface.field, parse_name(*field));
  }
  if (const auto component = map.find("component")) {
    surface.component = parse_component(*component);
  }
  if (const auto values = map.require("values")) {
    assign(surface.values, values->numbers(0));
    if (surface.values.size() > most_isovalues) {
      values->fail(std::to_string(surface.values.size()) + " isovalues, more than " +
                   std::to_string(most_isovalues));
    }
  }
  if (const auto opacity = map.find("opacity")) {
    assign(surface.opacity, opacity->number({0, 1}));
  }
  if (const auto color = map.find("color")) {
    if (color->is_map()) {
      surface.color = parse_color_by(*color, context);
    } else {
      surface.color = parse_color(*color, std::get<Color>(surface.color));
    }
  }
  return surface;
}

void parse_size(const Cursor& cursor, std::array<int, 2>& size) {
  const auto items = cursor.items();
  if (!items) {
    return;
  }
  if (items->size() != 2) {
    cursor.expected("a list of 2 integers, width and height");
    return;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    if (const auto side = (*items)[i].integer(1, largest_image_side)) {
      size[i] = static_cast<int>(*side);
    }
  }
}

} // namespace

Color parse_color(const Cursor& cursor, const Color& fallback) {
  if (cursor.is_list()) {
    const auto values = cursor.numbers(3, {0, 1});
    return values ? Color{(*values)[0], (*values)[1], (*values)[2]} : fallback;
  }
  if (!cursor.is_text() || cursor.node().text.empty()) {
    cursor.expected(
        "a colour (a list of 3 numbers from 0 to 1, '#rrggbb' within quotes, or a name)");
    return fallback;
  }
  const std::string& text = cursor.node().text;
  if (const auto color = hexadecimal_color(text)) {
    return *color;
  }
  std::vector<std::string> names;
  for (const NamedColor& named : named_colors) {
    if (text == named.name) {
      return named.color;
    }
    names.emplace_back(named.name);
  }
  std::string all;
  for (const std::string& name : names) {
    all += ", " + name;
  }
  cursor.fail(quote(text) +
              " is not a colour: a list of 3 numbers from 0 to 1, '#rrggbb' within quotes" + all +
              core::did_you_mean(text, names));
  return fallback;
}

Volume parse_volume(const Cursor& cursor, const ParseContext& context) {
  Volume volume;
  volume.line = cursor.line();
  const MapReader map(cursor,
                      {"field", "component", "colors", "range", "opacity", "unit_distance", "smooth"});
  if (const auto field = map.require("field")) {
    assign(volume.field, parse_name(*field));
  }
  if (const auto component = map.find("component")) {
    volume.component = parse_component(*component);
  }
  if (const auto colors = map.find("colors")) {
    volume.colors = parse_color_map(*colors, context);
  }
  if (const auto range = map.find("range")) {
    volume.range = parse_range(*range);
  }
  if (const auto opacity = map.find("opacity")) {
    volume.opacity = parse_opacity(*opacity);
  }
  if (const auto smooth = map.find("smooth")) {
    assign(volume.smooth, smooth->boolean());
  }
  if (const auto distance = map.find("unit_distance")) {
    assign(volume.unit_distance, distance->number(positive));
  }
  return volume;
}

std::vector<Isosurface> parse_isosurfaces(const Cursor& cursor, const ParseContext& context) {
  std::vector<Isosurface> surfaces;
  const auto items = cursor.items();
  for (const Cursor& item : items ? *items : std::vector<Cursor>{}) {
    surfaces.push_back(parse_isosurface(item, context));
  }
  return surfaces;
}

Frame parse_frame(const Cursor& cursor, ParseContext& context) {
  Frame frame;
  frame.line = cursor.line();
  const MapReader map(cursor,
                      {"name", "mesh", "size", "background", "camera", "volume", "isosurfaces",
                       "scalar_bar", "time_label", "effects", "accuracy", "step", "every", "when"});
  parse_item_name(map, context, frame.name);
  if (const auto mesh = map.find("mesh")) {
    assign(frame.mesh, parse_name(*mesh));
  }
  if (const auto size = map.find("size")) {
    parse_size(*size, frame.size);
  }
  if (const auto background = map.find("background")) {
    frame.background = parse_color(*background, frame.background);
  }
  if (const auto camera = map.find("camera")) {
    frame.camera = parse_camera(*camera);
  }
  if (const auto volume = map.find("volume")) {
    frame.volume = parse_volume(*volume, context);
  }
  const auto surfaces = map.find("isosurfaces");
  if (surfaces) {
    frame.isosurfaces = parse_isosurfaces(*surfaces, context);
  }
  if (const auto bar = map.find("scalar_bar")) {
    assign(frame.scalar_bar, bar->boolean());
  }
  if (const auto label = map.find("time_label")) {
    assign(frame.time_label, label->boolean());
  }
  if (const auto effects = map.find("effects")) {
    frame.effects = parse_effects<FrameEffect>(*effects, {{"lighting", FrameEffect::lighting},
                                                          {"shadows", {}},
                                                          {"ambient_occlusion", {}},
                                                          {"single_scattering", {}},
                                                          {"multiple_scattering", {}}});
  }
  if (const auto accuracy = map.find("accuracy")) {
    assign(frame.accuracy, parse_accuracy(*accuracy));
  }
  if (const auto step = map.find("step")) {
    assign(frame.step, step->number({0.01, 100}));
  }
  if (map && !map.has("volume") &&
      (!surfaces || (surfaces->is_list() && frame.isosurfaces.empty()))) {
    cursor.fail("the frame draws nothing; give it a 'volume' or 'isosurfaces'");
  }
  frame.trigger = parse_trigger(map, context.trigger);
  return frame;
}

} // namespace insitu::scene
