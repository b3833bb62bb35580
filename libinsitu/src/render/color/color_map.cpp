#include "render/color/color_map.h"

#include <algorithm>
#include <array>

#include "core/status.h"
#include "core/suggest.h"
#include "render/color/color_space.h"

namespace insitu::render {

namespace {

/// Our own few control points. The perceptual maps follow published descriptions: viridis and
/// inferno rise evenly in CIELAB lightness from dark blue-violet over teal, or over red, to yellow;
/// turbo runs the rainbow with lightness peaking in the middle; cool_warm is Moreland's (2009) pair
/// of ends with their unsaturated middle.
struct BuiltIn {
  const char* name;
  ColorSpace space;
  std::vector<ColorPoint> points;
};

const std::vector<BuiltIn>& built_ins() {
  static const std::vector<BuiltIn> maps = {
      {"viridis",
       ColorSpace::lab,
       {{0.0, 0.27, 0.00, 0.33},
        {0.25, 0.23, 0.32, 0.55},
        {0.5, 0.13, 0.57, 0.55},
        {0.75, 0.37, 0.79, 0.38},
        {1.0, 0.99, 0.91, 0.15}}},
      {"inferno",
       ColorSpace::lab,
       {{0.0, 0.00, 0.00, 0.02},
        {0.25, 0.34, 0.06, 0.43},
        {0.5, 0.73, 0.21, 0.33},
        {0.75, 0.98, 0.56, 0.04},
        {1.0, 0.99, 1.00, 0.64}}},
      {"turbo",
       ColorSpace::rgb,
       {{0.0, 0.19, 0.07, 0.23},
        {0.125, 0.27, 0.41, 0.90},
        {0.25, 0.16, 0.74, 0.92},
        {0.375, 0.18, 0.95, 0.60},
        {0.5, 0.64, 0.99, 0.24},
        {0.625, 0.93, 0.81, 0.23},
        {0.75, 0.98, 0.50, 0.13},
        {0.875, 0.82, 0.18, 0.03},
        {1.0, 0.48, 0.02, 0.01}}},
      {"cool_warm", ColorSpace::diverging, {{0.0, 0.23, 0.30, 0.75}, {1.0, 0.71, 0.02, 0.15}}},
      {"grey", ColorSpace::lab, {{0.0, 0.0, 0.0, 0.0}, {1.0, 1.0, 1.0, 1.0}}},
      {"rainbow", ColorSpace::hsv, {{0.0, 0.0, 0.0, 1.0}, {1.0, 1.0, 0.0, 0.0}}},
  };
  return maps;
}

} // namespace

ColorMap::ColorMap(std::string name, ColorSpace space, std::vector<ColorPoint> points,
                   const Color& nan_color)
    : name_(std::move(name)), space_(space), points_(std::move(points)), nan_color_(nan_color) {
  if (points_.empty())
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "colour map '" + name_ + "': no control point; at least one expected");
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ColorPoint& p = points_[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.r) || !std::isfinite(p.g) || !std::isfinite(p.b))
      throw core::Error(INSITU_ERROR_ARGUMENT, "colour map '" + name_ + "': control point " +
                                                   std::to_string(i) + " is not finite");
    if (i > 0 && p.x < points_[i - 1].x)
      throw core::Error(INSITU_ERROR_ARGUMENT,
                        "colour map '" + name_ + "': control point " + std::to_string(i) + " at " +
                            std::to_string(p.x) + " lies below the one before it at " +
                            std::to_string(points_[i - 1].x));
  }
}

ColorMap ColorMap::built_in(std::string_view name) {
  for (const BuiltIn& map : built_ins())
    if (map.name == name || (name == "gray" && std::string_view(map.name) == "grey"))
      return ColorMap(map.name, map.space, map.points, {0.5f, 0.5f, 0.5f});
  std::string known;
  for (const std::string& other : built_in_names())
    known += (known.empty() ? "" : ", ") + other;
  throw core::Error(INSITU_ERROR_SCENE, "no built-in colour map is called '" + std::string(name) +
                                            "' (" + known + ", or a .json file)" +
                                            core::did_you_mean(name, built_in_names()));
}

std::vector<std::string> ColorMap::built_in_names() {
  std::vector<std::string> names;
  for (const BuiltIn& map : built_ins())
    names.emplace_back(map.name);
  return names;
}

Color ColorMap::at(double u) const {
  if (std::isnan(u))
    return nan_color_;
  const auto color_of = [](const ColorPoint& p) { return linear_of_srgb(p.r, p.g, p.b); };
  if (u <= 0.0 || points_.size() == 1)
    return color_of(points_.front());
  if (u >= 1.0)
    return color_of(points_.back());
  const double x = points_.front().x + u * (points_.back().x - points_.front().x);
  const auto above = std::upper_bound(points_.begin(), points_.end(), x,
                                      [](double v, const ColorPoint& p) { return v < p.x; });
  if (above == points_.begin())
    return color_of(points_.front());
  if (above == points_.end())
    return color_of(points_.back());
  const ColorPoint& a = *(above - 1);
  const ColorPoint& b = *above;
  return mix(space_, {a.r, a.g, a.b}, {b.r, b.g, b.b}, (x - a.x) / (b.x - a.x));
}

} // namespace insitu::render
