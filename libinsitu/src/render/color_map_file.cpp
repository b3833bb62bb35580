#include <fstream>
#include <sstream>
#include <yaml-cpp/yaml.h>

#include "core/status.h"
#include "core/suggest.h"
#include "render/color_map.h"

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

Color nan_color(const YAML::Node& map, const std::string& where) {
  const YAML::Node node = map["NanColor"];
  if (!node)
    return {0.5f, 0.5f, 0.5f};
  if (!node.IsSequence() || node.size() != 3)
    fail(where, "NanColor: a list of 3 numbers expected");
  double c[3];
  for (std::size_t i = 0; i < 3; ++i)
    c[i] = number(node[i], where, "NanColor[" + std::to_string(i) + "]");
  return linear_of_srgb(c[0], c[1], c[2]);
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

ColorMap read_map(const YAML::Node& map, const std::string& source) {
  const std::string name = text_of(map["Name"]);
  const std::string where = name.empty() ? source : source + ", map '" + name + "'";
  const ColorSpace space = color_space(map, where);
  return ColorMap(name.empty() ? source : name, space, color_points(map["RGBPoints"], where),
                  nan_color(map, where));
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
    // A list may hold categorical maps too, which have no RGBPoints.
    if (name.empty() ? bool(map["RGBPoints"]) : names.back() == name)
      return read_map(map, source);
  }
  if (!name.empty())
    fail(source, "no map is called '" + name + "'" + core::did_you_mean(name, names));
  fail(source, names.empty() ? "the list is empty" : "no map has RGBPoints");
}

ColorMap load_color_map(const std::string& path, const std::string& name) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf()))
    throw core::Error(INSITU_ERROR_FILE, "colour map file '" + path + "' cannot be read");
  return parse_color_map(text.str(), "'" + path + "'", name);
}

} // namespace insitu::render
