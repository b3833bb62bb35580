#pragma once

#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "render/color/color_map.h"

namespace insitu::render {

struct OpacityPoint {
  double value = 0, opacity = 0;
  friend bool operator==(const OpacityPoint&, const OpacityPoint&) = default;
};

/// Colour and opacity of a value. Colours stretch over [low, high], evenly or by the logarithm, as
/// the map's scale says; beyond, they are the map's colours below and above, or those of its ends.
/// Values from 0 down are below every logarithmic range. Opacity is linear between its points, in
/// the logarithm where the scale is logarithmic and both points are above 0, and constant beyond
/// them (no points: from 0 at low to 1 at high).
class TransferFunction {
public:
  /// Throws core::Error (INSITU_ERROR_ARGUMENT) unless low and high are finite, low <= high, on a
  /// logarithmic scale low > 0, and the points ascend with opacities from 0 to 1. With low = high,
  /// values below take the map's first colour and the rest its last.
  TransferFunction(ColorMap colors, double low, double high,
                   std::vector<OpacityPoint> opacity = {});

  /// An opacity below this counts as none: rounding makes as much of values just where opacity
  /// begins.
  static constexpr double invisible = 1e-13;

  Color color(double value) const;
  double opacity(double value) const;
  /// Its limit from below.
  double opacity_below(double value) const;
  /// The least upper bound of opacity(v) over v in [low, high], low <= high.
  double max_opacity(double low, double high) const;
  /// Of values that are not numbers, in a volume. Default 0.
  void set_nan_opacity(double opacity) { nan_opacity_ = opacity; }
  double nan_opacity() const { return nan_opacity_; }

  double low() const { return low_; }
  double high() const { return high_; }
  Scale scale() const { return colors_.scale(); }
  /// The value a part u of the way from one to another, on the scale; linear unless both are above
  /// 0.
  double value_between(double from, double to, double u) const;
  const ColorMap& colors() const { return colors_; }
  const std::vector<OpacityPoint>& opacity_points() const { return opacity_; }

private:
  double opacity_between(const OpacityPoint& a, const OpacityPoint& b, double value) const;

  ColorMap colors_;
  double low_, high_;
  std::vector<OpacityPoint> opacity_;
  double nan_opacity_ = 0;
};

struct ColorSample {
  Color color;
  float alpha = 0;
};

/// Where a value lies on a scale, for tables: the value, or what stands in for its logarithm, which
/// costs as little: linear between powers of two, and monotone. Of numbers above 0 on a logarithmic
/// scale; others lie below all of these.
inline double place_of(double value, bool log) {
  return log ? double(std::bit_cast<std::int64_t>(value)) * 0x1p-52 : value;
}
/// The value at a place.
inline double value_at(double place, bool log) {
  return log ? std::bit_cast<double>(std::int64_t(place * 0x1p52)) : place;
}

/// The colours of a transfer function: a table over their range, linear in between.
class ColorTable {
public:
  static constexpr int size = 4096;

  explicit ColorTable(const TransferFunction& function);

  /// Of a number.
  Color operator()(double value) const {
    const double at = place(value);
    if (!(at > 0.0) || at >= size)
      return at_end(value, at);
    const int i = int(at);
    const float w = float(at - i);
    return (1.0f - w) * color_[std::size_t(i)] + w * color_[std::size_t(i) + 1];
  }

  /// Entry i, and the value it is of.
  const Color& entry(int i) const { return color_[std::size_t(i)]; }
  double value_of(int i) const { return scale_ > 0.0 ? value_at(start_ + i / scale_, log_) : low_; }
  /// Which entries a value lies between, and how far on: below 0 or from `size` on beyond them.
  double place(double value) const { return (place_of(value, log_) - start_) * scale_; }

private:
  Color at_end(double value, double at) const;

  std::vector<Color> color_;
  Color below_, above_;
  double low_, high_, start_, scale_;
  bool log_;
};

/// A transfer function made ready for samples that stand for `step` of ray each: opacities, which
/// hold for unit_distance, become 1 - (1 - a)^(step / unit_distance). Values are classified after
/// interpolation, by tables, linear in between: one over the colours' range, one for each stretch
/// between two opacity points, so that a sudden step of opacity stays one; and one of both together
/// where opacity is as even as colours are.
class Classifier {
public:
  static constexpr int table_size = ColorTable::size;

  Classifier(const TransferFunction& function, double step, double unit_distance);

  ColorSample operator()(double value) const {
    const Rgba c = rgba(value);
    return {color_of(c), c[3]};
  }
  /// The same in one register.
  Rgba rgba(double value) const {
    const double at = colors_.place(value);
    if (!(at > 0.0 && at < ColorTable::size))
      return by_stretches(value);
    const auto i = std::size_t(at);
    if (!is_joint_[i])
      return by_stretches(value);
    const float w = float(at - double(i));
    const Rgba c = (1.0f - w) * joint_[i] + w * joint_[i + 1];
    return c[3] >= least_ ? c : Rgba{};
  }
  float alpha(double value) const {
    if (!(value >= stretches_.front().value))
      return below_;
    std::size_t i = stretches_.size() - 1;
    if (i < 8)
      for (; value < stretches_[i].value; --i) {
      }
    else
      i = stretch_of(value);
    const Stretch& s = stretches_[i];
    const double at = (place_of(value, s.log) - s.start) * s.scale;
    const float* table = alpha_.data() + s.first;
    float a;
    if (!(at > 0.0)) {
      a = table[0];
    } else if (at >= s.count) {
      a = table[s.count];
    } else {
      const int k = int(at);
      const float w = float(at - k);
      a = (1.0f - w) * table[k] + w * table[k + 1];
    }
    return a >= least_ ? a : 0.0f;
  }
  /// The alpha of a part of a step.
  static float partial(float alpha, double fraction);

private:
  Rgba by_stretches(double value) const {
    if (value != value)
      return rgba_of(nan_color_, nan_alpha_);
    const float a = alpha(value);
    return a > 0.0f ? rgba_of(colors_(value), a) : Rgba{};
  }
  /// From one opacity point to the next.
  struct Stretch {
    double value, start, scale; ///< start: the value's place on the scale
    int first, count;           ///< table entries: count + 1 from `first`
    bool log;
  };
  std::size_t stretch_of(double value) const;
  void set_joint();
  /// The stretch from `first` to `last` that holds a value.
  std::size_t stretch_of(double value, std::size_t first, std::size_t last) const;

  ColorTable colors_;
  std::vector<float> alpha_;
  std::vector<Stretch> stretches_;     ///< ascending; the last is all beyond the last point
  std::vector<Rgba> joint_;            ///< at the entries of colors_
  std::vector<std::uint8_t> is_joint_; ///< what is between two entries is linear enough
  float below_, least_;
  Color nan_color_;
  float nan_alpha_;
};

} // namespace insitu::render
