#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/color/color.h"

namespace insitu::render {

/// In which a colour map is interpolated between its control points. rgb: in sRGB, as stored;
/// linear: in linear light; diverging: Moreland (2009), "Diverging Color Maps for Scientific
/// Visualization", through Msh.
enum class ColorSpace { rgb, hsv, lab, diverging, linear };

/// How colours stretch over a range of values: evenly by the value, or by its logarithm.
enum class Scale { linear, log };

/// A control point, in sRGB.
struct ColorPoint {
  double x = 0;
  double r = 0, g = 0, b = 0;
};

/// Opacity at a place of a colour map, linear between places.
struct MapOpacity {
  double u = 0, opacity = 0;
  friend bool operator==(const MapOpacity&, const MapOpacity&) = default;
};

/// Colours over [0, 1]: control points in ascending order, stretched from their first to their
/// last.
class ColorMap {
public:
  /// At least one point, x not descending and finite; throws core::Error (INSITU_ERROR_ARGUMENT).
  ColorMap(std::string name, ColorSpace space, std::vector<ColorPoint> points,
           const Color& nan_color = {});

  /// The built-in map of this name; throws INSITU_ERROR_SCENE with the nearest name.
  static ColorMap built_in(std::string_view name);
  static std::vector<std::string> built_in_names();

  /// Linear RGB at u; outside [0, 1] the colour of the end.
  Color at(double u) const;
  /// Linear RGB of a value that is not a number.
  const Color& nan_color() const { return nan_color_; }
  void set_nan_color(const Color& color) { nan_color_ = color; }
  /// Linear RGB of values below and above the range; none: the colours of the ends.
  const std::optional<Color>& below() const { return below_; }
  const std::optional<Color>& above() const { return above_; }
  void set_below(const Color& color) { below_ = color; }
  void set_above(const Color& color) { above_ = color; }
  Scale scale() const { return scale_; }
  void set_scale(Scale scale) { scale_ = scale; }
  const std::string& name() const { return name_; }
  const std::vector<ColorPoint>& points() const { return points_; }
  /// Opacities that came with the map, u not descending, perhaps beyond [0, 1]; empty: none did.
  const std::vector<MapOpacity>& opacity() const { return opacity_; }
  void set_opacity(std::vector<MapOpacity> opacity) { opacity_ = std::move(opacity); }

private:
  std::string name_;
  ColorSpace space_;
  std::vector<ColorPoint> points_;
  Color nan_color_;
  std::optional<Color> below_, above_;
  Scale scale_ = Scale::linear;
  std::vector<MapOpacity> opacity_;
};

/// ParaView's JSON: a list of {Name, ColorSpace, RGBPoints [x, r, g, b, ...], NanColor, Points [x,
/// opacity, midpoint, sharpness, ...], UseLogScale, UseBelowRangeColor, BelowRangeColor,
/// UseAboveRangeColor, AboveRangeColor}, or one such map; opacities are placed by RGBPoints' own
/// range. With UseLogScale points lie between each other by the logarithms of their x; colours
/// whose x are not all above 0 lie evenly, as in ParaView. A map of categories (IndexedColors [r,
/// g, b, ...] instead of RGBPoints) becomes steps of equal width. `name` picks one of several;
/// empty: the first that has RGBPoints, or else the first with IndexedColors. `source` is what
/// messages call the text. Throws core::Error (INSITU_ERROR_SCENE) naming the map, the key and what
/// was found.
ColorMap parse_color_map(const std::string& text, const std::string& source,
                         const std::string& name = {});
/// The same from a file; INSITU_ERROR_FILE if it cannot be read.
ColorMap load_color_map(const std::string& path, const std::string& name = {});

} // namespace insitu::render
