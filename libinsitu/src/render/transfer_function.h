#pragma once

#include <utility>
#include <vector>

#include "render/color_map.h"

namespace insitu::render {

struct OpacityPoint {
  double value = 0, opacity = 0;
  friend bool operator==(const OpacityPoint&, const OpacityPoint&) = default;
};

/// Colour and opacity of a value. Colours stretch over [low, high]; opacity is linear between its
/// points and constant beyond them (no points: from 0 at low to 1 at high).
class TransferFunction {
public:
  /// Throws core::Error (INSITU_ERROR_ARGUMENT) unless low and high are finite, low <= high, and
  /// the points ascend with opacities from 0 to 1. With low = high, values below take the map's
  /// first colour and the rest its last.
  TransferFunction(ColorMap colors, double low, double high,
                   std::vector<OpacityPoint> opacity = {});

  /// An opacity below this counts as none: rounding makes as much of values just where opacity
  /// begins.
  static constexpr double invisible = 1e-13;

  Color color(double value) const;
  double opacity(double value) const;
  /// The least upper bound of opacity(v) over v in [low, high], low <= high.
  double max_opacity(double low, double high) const;
  /// Of values that are not numbers, in a volume. Default 0.
  void set_nan_opacity(double opacity) { nan_opacity_ = opacity; }
  double nan_opacity() const { return nan_opacity_; }

  double low() const { return low_; }
  double high() const { return high_; }
  const ColorMap& colors() const { return colors_; }
  const std::vector<OpacityPoint>& opacity_points() const { return opacity_; }

private:
  ColorMap colors_;
  double low_, high_;
  std::vector<OpacityPoint> opacity_;
  double nan_opacity_ = 0;
};

struct ColorSample {
  Color color;
  float alpha = 0;
};

/// A transfer function made ready for samples that stand for `step` of ray each: opacities, which
/// hold for unit_distance, become 1 - (1 - a)^(step / unit_distance). Values are classified after
/// interpolation, by tables of table_size intervals (colours over [low, high], opacities over their
/// points), linear in between; so a sudden step of opacity is smeared over 1/table_size of that
/// range.
class Classifier {
public:
  static constexpr int table_size = 4096;

  Classifier(const TransferFunction& function, double step, double unit_distance);

  ColorSample operator()(double value) const {
    ColorSample s;
    if (value != value) {
      s.color = nan_color_;
      s.alpha = nan_alpha_;
      return s;
    }
    s.alpha = lookup(alpha_, (value - alpha_low_) * alpha_scale_);
    if (s.alpha > 0.0f)
      s.color = lookup(color_, (value - color_low_) * color_scale_);
    return s;
  }
  /// The alpha of a part of a step.
  static float partial(float alpha, double fraction);

private:
  template <class T>
  static T lookup(const std::vector<T>& table, double at) {
    if (!(at > 0.0))
      return table.front();
    if (at >= table_size)
      return table.back();
    const int i = int(at);
    const float w = float(at - i);
    return (1.0f - w) * table[std::size_t(i)] + w * table[std::size_t(i) + 1];
  }

  std::vector<Color> color_;
  std::vector<float> alpha_;
  double color_low_, color_scale_, alpha_low_, alpha_scale_;
  Color nan_color_;
  float nan_alpha_;
};

} // namespace insitu::render
