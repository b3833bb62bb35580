#include <algorithm>
#include <cmath>
#include <optional>
#include <yaml-cpp/yaml.h>

#include "core/status.h"
#include "core/suggest.h"
#include "core/text.h"
#include "render/color/color_map.h"

namespace insitu::render {

namespace {

[[noreturn]] void fail(const std::string& source, const std::string& message) {
  throw core::Error(INSITU_ERROR_SCENE, "colour map " + source + ": " + message);
}

struct SpaceName {
  const char* name;
  ColorSpace space;
};
// CIELAB's other paths are near enough to Lab's to be drawn by it; "Step" is not.
constexpr SpaceName space_names[] = {
    {"RGB", ColorSpace::rgb}, {"Lab", ColorSpace::lab},    {"Diverging", ColorSpace::diverging},
    {"HSV", ColorSpace::hsv}, {"CIELAB", ColorSpace::lab}, {"Linear", ColorSpace::linear},
};

std::string text_of(const YAML::Node& node) {
  return node && node.IsScalar() ? node.Scalar() : std::string();
}

double number(const YAML::Node& node, const std::string& source, const std::string& what) {
  double value = 0;
  try {
    value = node.as<double>();
  } catch (const YAML::Exception&) {
    fail(source, what + " is not a number ('" + text_of(node) + "')");
  }
  return value;
}

/// The colour of a key that holds one; nothing without the key.
std::optional<Color> color_of(const YAML::Node& map, const std::string& where,
                              const std::string& key) {
  const YAML::Node node = map[key];
  if (!node)
    return std::nullopt;
  if (!node.IsSequence() || node.size() != 3)
    fail(where, key + ": a list of 3 numbers expected");
  double c[3];
  for (std::size_t i = 0; i < 3; ++i)
    c[i] = number(node[i], where, key + "[" + std::to_string(i) + "]");
  return linear_of_srgb(c[0], c[1], c[2]);
}

/// ParaView writes them as 0 and 1.
bool is_on(const YAML::Node& map, const std::string& where, const std::string& key) {
  const YAML::Node node = map[key];
  if (!node)
    return false;
  if (text_of(node) == "true" || text_of(node) == "false")
    return text_of(node) == "true";
  return number(node, where, key) != 0;
}

/// The colour beyond one end of the range, `side` of Below and Above, if it is to be used. ParaView
/// leaves out what is as it would be anyway: black below, white above.
std::optional<Color> beyond(const YAML::Node& map, const std::string& where,
                            const std::string& side, const Color& standard) {
  if (!is_on(map, where, "Use" + side + "RangeColor"))
    return std::nullopt;
  return color_of(map, where, side + "RangeColor").value_or(standard);
}

ColorSpace color_space(const YAML::Node& map, const std::string& where) {
  const YAML::Node node = map["ColorSpace"];
  if (!node)
    return ColorSpace::rgb; // ParaView's own reading of maps without one
  std::vector<std::string> known;
  for (const SpaceName& space : space_names) {
    if (text_of(node) == space.name)
      return space.space;
    known.emplace_back(space.name);
  }
  fail(where, "ColorSpace '" + text_of(node) + "' is not known (RGB, Lab, Diverging, HSV, Linear)" +
                  core::did_you_mean(text_of(node), known));
}

std::vector<ColorPoint> color_points(const YAML::Node& node, const std::string& where) {
  if (!node || !node.IsSequence())
    fail(where, "RGBPoints: a list [x, r, g, b, ...] expected");
  if (node.size() == 0 || node.size() % 4 != 0)
    fail(where, "RGBPoints: 4 numbers a point expected (x, r, g, b), " +
                    std::to_string(node.size()) + " given");
  std::vector<double> values;
  values.reserve(node.size());
  // By iterator: indexing a long list of yaml-cpp's is not constant time.
  for (const YAML::Node& item : node) {
    const std::size_t i = values.size();
    const double v = number(item, where, "RGBPoints[" + std::to_string(i) + "]");
    if (!std::isfinite(v) || (i % 4 != 0 && (v < 0 || v > 1)))
      fail(where, "RGBPoints[" + std::to_string(i) + "] is " + text_of(item) +
                      (i % 4 == 0 ? "; a finite number expected" : "; 0 to 1 expected"));
    if (i % 4 == 0 && i > 0 && v < values[i - 4])
      fail(where, "RGBPoints[" + std::to_string(i) + "] is " + text_of(item) +
                      ", below the point before it");
    values.push_back(v);
  }
  std::vector<ColorPoint> points;
  for (std::size_t i = 0; i < values.size(); i += 4)
    points.push_back({values[i], values[i + 1], values[i + 2], values[i + 3]});
  return points;
}

/// A list of groups of `width` finite numbers, those but the first of each from 0 to 1; with
/// `placed`, the first of each is a place, which does not descend.
std::vector<double> groups(const YAML::Node& node, const std::string& where, const std::string& key,
                           std::size_t width, const char* form, bool placed) {
  if (!node.IsSequence() || node.size() == 0 || node.size() % width != 0)
    fail(where,
         key + ": a list " + form + " expected" +
             (node.IsSequence() ? ", " + std::to_string(node.size()) + " numbers given" : ""));
  std::vector<double> values;
  values.reserve(node.size());
  for (const YAML::Node& item : node) {
    const std::size_t i = values.size();
    const std::string which = key + "[" + std::to_string(i) + "]";
    const double v = number(item, where, which);
    const bool place = placed && i % width == 0;
    if (!std::isfinite(v) || (!place && (v < 0 || v > 1)))
      fail(where, which + " is " + text_of(item) +
                      (place ? "; a finite number expected" : "; 0 to 1 expected"));
    if (place && i > 0 && v < values[i - width])
      fail(where, which + " is " + text_of(item) + ", below the point before it");
    values.push_back(v);
  }
  return values;
}

/// Colours of categories, as steps of equal width.
std::vector<ColorPoint> category_points(const YAML::Node& node, const std::string& where) {
  const std::vector<double> c = groups(node, where, "IndexedColors", 3, "[r, g, b, ...]", false);
  const std::size_t count = c.size() / 3;
  std::vector<ColorPoint> points;
  for (std::size_t i = 0; i < count; ++i)
    for (const std::size_t end : {i, i + 1})
      points.push_back({double(end) / double(count), c[3 * i], c[3 * i + 1], c[3 * i + 2]});
  return points;
}

/// What ParaView (vtkPiecewiseFunction) makes of a part u of the way between two opacities.
double between(double from, double to, double u, double midpoint, double sharpness) {
  if (u < midpoint)
    u = 0.5 * u / midpoint;
  else
    u = midpoint < 1 ? 0.5 + 0.5 * (u - midpoint) / (1 - midpoint) : 0.5;
  if (sharpness > 0.99)
    return u < 0.5 ? from : to;
  if (sharpness >= 0.01) {
    u = u < 0.5 ? 0.5 * std::pow(2 * u, 1 + 10 * sharpness)
                : 1 - 0.5 * std::pow(2 * (1 - u), 1 + 10 * sharpness);
    // A Hermite curve whose slope at both ends falls with the sharpness.
    const double square = u * u, cube = square * u, slope = (1 - sharpness) * (to - from);
    const double value = (2 * cube - 3 * square + 1) * from + (3 * square - 2 * cube) * to +
                         (cube - 2 * square + u) * slope + (cube - square) * slope;
    return std::clamp(value, std::min(from, to), std::max(from, to));
  }
  return from + u * (to - from);
}

/// Curved parts become this many straight ones.
constexpr int opacity_parts = 32;

/// colors: by which opacities are placed; with `log` their x are logarithms.
std::vector<MapOpacity> opacity_points(const YAML::Node& node, const std::string& where,
                                       const std::vector<ColorPoint>& colors, bool log) {
  std::vector<double> v =
      groups(node, where, "Points", 4, "[x, opacity, midpoint, sharpness, ...]", true);
  for (std::size_t i = 0; log && i < v.size(); i += 4) {
    if (!(v[i] > 0))
      fail(where, "Points[" + std::to_string(i) + "] is " + std::to_string(v[i]) +
                      "; above 0 expected with UseLogScale");
    v[i] = std::log(v[i]);
  }
  const bool own = !(colors.back().x > colors.front().x);
  const double first = own ? v[0] : colors.front().x;
  const double last = own ? v[v.size() - 4] : colors.back().x;
  const auto place = [&](double x) { return last > first ? (x - first) / (last - first) : 0.0; };
  std::vector<MapOpacity> points{{place(v[0]), v[1]}};
  for (std::size_t i = 4; i < v.size(); i += 4) {
    const double from = place(v[i - 4]), to = place(v[i]), midpoint = v[i - 2], sharp = v[i - 1];
    if (sharp > 0.99) { // a step, at the midpoint
      const double at = from + midpoint * (to - from);
      points.push_back({at, v[i - 3]});
      points.push_back({at, v[i + 1]});
    } else if (midpoint != 0.5 || sharp >= 0.01) {
      for (int k = 1; k < opacity_parts; ++k) {
        const double u = double(k) / opacity_parts;
        points.push_back({from + u * (to - from), between(v[i - 3], v[i + 1], u, midpoint, sharp)});
      }
    }
    points.push_back({to, v[i + 1]});
  }
  return points;
}

ColorMap read_map(const YAML::Node& map, const std::string& source) {
  const std::string name = text_of(map["Name"]);
  const std::string where = name.empty() ? source : source + ", map '" + name + "'";
  const bool categories = map["IndexedColors"] && !map["RGBPoints"];
  const ColorSpace space = categories ? ColorSpace::rgb : color_space(map, where);
  std::vector<ColorPoint> points = categories ? category_points(map["IndexedColors"], where)
                                              : color_points(map["RGBPoints"], where);
  const bool log = is_on(map, where, "UseLogScale");
  const bool by_logarithm = log && points.front().x > 0; // categories begin at 0
  for (ColorPoint& p : points)
    p.x = by_logarithm ? std::log(p.x) : p.x;
  ColorMap colors(name.empty() ? source : name, space, points,
                  color_of(map, where, "NanColor").value_or(Color{0.5f, 0.5f, 0.5f}));
  colors.set_scale(log ? Scale::log : Scale::linear);
  if (const auto color = beyond(map, where, "Below", {0, 0, 0}))
    colors.set_below(*color);
  if (const auto color = beyond(map, where, "Above", {1, 1, 1}))
    colors.set_above(*color);
  if (map["Points"])
    colors.set_opacity(opacity_points(map["Points"], where, points, by_logarithm));
  return colors;
}

} // namespace

ColorMap parse_color_map(const std::string& text, const std::string& source,
                         const std::string& name) {
  YAML::Node root;
  try {
    root = YAML::Load(text); // JSON is YAML
  } catch (const YAML::Exception& e) {
    fail(source, "line " + std::to_string(e.mark.line + 1) + ": " + e.msg);
  }
  if (root.IsMap())
    return read_map(root, source);
  if (!root.IsSequence())
    fail(source, "a list of maps expected, as ParaView exports it");
  std::vector<std::string> names;
  for (const YAML::Node& map : root) {
    if (!map.IsMap())
      fail(source, "a list of maps expected, as ParaView exports it");
    names.push_back(text_of(map["Name"]));
    // A list may hold maps of categories too, which have no RGBPoints.
    if (name.empty() ? bool(map["RGBPoints"]) : names.back() == name)
      return read_map(map, source);
  }
  for (const YAML::Node& map : root)
    if (name.empty() && map["IndexedColors"])
      return read_map(map, source);
  if (!name.empty())
    fail(source, "no map is called '" + name + "'" + core::did_you_mean(name, names));
  fail(source, names.empty() ? "the list is empty" : "no map has RGBPoints or IndexedColors");
}

ColorMap load_color_map(const std::string& path, const std::string& name) {
  const std::optional<std::string> text = core::read_file(path);
  if (!text || text->empty())
    throw core::Error(INSITU_ERROR_FILE, "colour map file '" + path + "' cannot be read");
  return parse_color_map(*text, "'" + path + "'", name);
}

} // namespace insitu::render
