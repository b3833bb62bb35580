#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

/// As displayed, from 0 to 1 each.
struct NamedColor {
  const char* name;
  double red, green, blue;
};
constexpr NamedColor named_colors[] = {{"black", 0, 0, 0},
                                       {"white", 1, 1, 1},
                                       {"gray", 0.5, 0.5, 0.5},
                                       {"grey", 0.5, 0.5, 0.5},
                                       {"red", 1, 0, 0},
                                       {"green", 0, 0.5, 0},
                                       {"blue", 0, 0, 1},
                                       {"yellow", 1, 1, 0},
                                       {"cyan", 0, 1, 1},
                                       {"magenta", 1, 0, 1},
                                       {"orange", 1, 165 / 255.0, 0}};

int hexadecimal_digit(char c) {
  if (c >= '0' && c <= '9') {
    return c - '0';
  }
  if (c >= 'a' && c <= 'f') {
    return c - 'a' + 10;
  }
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

std::optional<render::Color> hexadecimal_color(const std::string& text) {
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
  return render::linear_of_srgb(parts[0], parts[1], parts[2]);
}

} // namespace

render::Color parse_color(const Cursor& cursor, const render::Color& fallback) {
  if (cursor.is_list()) {
    const auto values = cursor.numbers(3, {0, 1});
    return values ? render::linear_of_srgb((*values)[0], (*values)[1], (*values)[2]) : fallback;
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
      return render::linear_of_srgb(named.red, named.green, named.blue);
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

namespace {

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

} // namespace

ColorMapChoice parse_color_map(const MapReader& map, const ParseContext& context) {
  ColorMapChoice to;
  if (const auto colors = map.find("colors")) {
    to.line = colors->line();
    if (const auto name = colors->text()) {
      to.name = *name;
      const bool is_file = name->find('/') != std::string::npos ||
                           (name->size() > 5 && name->compare(name->size() - 5, 5, ".json") == 0);
      to.path = is_file ? resolve_path(*name, context.base_folder) : std::string();
    }
  }
  if (const auto scale = map.find("scale")) {
    to.scale = scale->choice<render::Scale>(
        {{"linear", render::Scale::linear}, {"log", render::Scale::log}});
  }
  if (const auto range = map.find("range")) {
    to.range = parse_range(*range);
    if (to.scale == render::Scale::log && to.range && !(to.range->low > 0)) {
      range->fail("'scale: log' needs a range above 0");
    }
  }
  const auto color = [&](const char* key, std::optional<render::Color>& into) {
    if (const auto given = map.find(key)) {
      into = parse_color(*given, {});
    }
  };
  color("below", to.below);
  color("above", to.above);
  color("nan", to.nan);
  return to;
}

} // namespace insitu::scene
