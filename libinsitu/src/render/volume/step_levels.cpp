#include "render/volume/step_levels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "core/status.h"

namespace insitu::render {

namespace {

/// Least and greatest extinction and emission over intervals of values.
class Variation {
public:
  Variation(const TransferFunction& function, double unit_distance) {
    values_.push_back(function.low());
    values_.push_back(function.high());
    for (const OpacityPoint& p : function.opacity_points()) {
      values_.push_back(p.value);
      values_.push_back(std::nextafter(p.value, -HUGE_VAL)); // the other side of a step
    }
    std::sort(values_.begin(), values_.end());
    const double first = values_.front(), last = values_.back();
    const double above_zero = *std::upper_bound(values_.begin(), values_.end() - 1, 0.0);
    constexpr int steps = 1024;
    for (int i = 1; i < steps; ++i)
      values_.push_back(first + (last - first) * (double(i) / steps));
    if (function.scale() == Scale::log)
      for (int i = 1; i < steps; ++i)
        values_.push_back(function.value_between(above_zero, last, double(i) / steps));
    if (function.colors().below())
      values_.push_back(std::nextafter(function.low(), -HUGE_VAL));
    if (function.colors().above())
      values_.push_back(std::nextafter(function.high(), HUGE_VAL));
    std::sort(values_.begin(), values_.end());
    values_.erase(std::unique(values_.begin(), values_.end()), values_.end());
    std::vector<Extremes> row;
    for (const double v : values_)
      row.push_back(at(function, v, unit_distance));
    jump_before_.assign(row.size(), 0.0);
    for (std::size_t i = 1; i < row.size(); ++i) {
      Extremes pair = row[i];
      pair.add(row[i - 1]);
      if (std::nextafter(values_[i - 1], HUGE_VAL) == values_[i])
        jump_before_[i] = pair.range();
    }
    below_ = at(function, -HUGE_VAL, unit_distance);
    above_ = at(function, HUGE_VAL, unit_distance);
    nan_ = at(function, std::nan(""), unit_distance);
    table_.push_back(std::move(row));
    for (std::size_t width = 1; 2 * width <= values_.size(); width *= 2) {
      const std::vector<Extremes>& half = table_.back();
      std::vector<Extremes> whole(values_.size() - 2 * width + 1);
      for (std::size_t i = 0; i < whole.size(); ++i) {
        whole[i] = half[i];
        whole[i].add(half[i + width]);
      }
      table_.push_back(std::move(whole));
    }
  }

  /// The largest range of extinction and emission over values in [low, high], to the tables'
  /// resolution.
  double over(double low, double high, bool with_nan) const {
    // From the last entry at or below to the first at or above.
    auto from = std::upper_bound(values_.begin(), values_.end(), low) - values_.begin() - 1;
    auto to = std::lower_bound(values_.begin(), values_.end(), high) - values_.begin();
    Extremes all;
    if (from < 0) {
      all.add(below_);
      from = 0;
    }
    if (to == std::ptrdiff_t(values_.size())) {
      all.add(above_);
      --to;
    }
    if (from <= to) {
      const std::size_t count = std::size_t(to - from) + 1;
      const std::size_t log = std::size_t(std::bit_width(count)) - 1;
      all.add(table_[log][std::size_t(from)]);
      all.add(table_[log][std::size_t(to) + 1 - (std::size_t(1) << log)]);
    }
    if (with_nan)
      all.add(nan_);
    return all.range();
  }

  /// The greatest step of extinction or emission at a value in [low, high].
  double step_within(double low, double high) const {
    const auto from = std::upper_bound(values_.begin(), values_.end(), low) - values_.begin();
    const auto to = std::upper_bound(values_.begin(), values_.end(), high) - values_.begin();
    return from < to ? *std::max_element(jump_before_.begin() + from, jump_before_.begin() + to)
                     : 0.0;
  }

private:
  struct Extremes {
    std::array<double, 4> low{HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL},
        high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    void add(const Extremes& b) {
      for (std::size_t c = 0; c < 4; ++c) {
        low[c] = std::min(low[c], b.low[c]);
        high[c] = std::max(high[c], b.high[c]);
      }
    }
    double range() const {
      double most = 0;
      for (std::size_t c = 0; c < 4; ++c)
        most = std::max(most, high[c] - low[c]);
      return most;
    }
  };
  static Extremes at(const TransferFunction& function, double value, double unit_distance) {
    // Beyond this extinction a unit distance lets nothing through that an image could show.
    const double t =
        std::min(20.0, -std::log1p(-std::min(1.0, function.opacity(value)))) / unit_distance;
    const Color c = function.color(value);
    Extremes e;
    e.low = e.high = {t, t * double(c.r), t * double(c.g), t * double(c.b)};
    return e;
  }

  std::vector<double> values_;
  std::vector<double>
      jump_before_; ///< the step from the value before, if there is no double between
  std::vector<std::vector<Extremes>> table_; ///< [log of width][first]
  Extremes below_, above_, nan_;
};

} // namespace

StepLevels::StepLevels(const Macrocells& cells, const TransferFunction& function,
                       double nominal_step, double unit_distance, double diagonal, double tolerance,
                       const core::CountedAllocator<std::uint8_t>& counted)
    : grid_(cells.grid()), base_step_(nominal_step), level_(counted) {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw core::Error(INSITU_ERROR_ARGUMENT, "a volume's tolerance of " +
                                                 std::to_string(tolerance) +
                                                 "; more than 0 expected");
  const Variation variation(function, unit_distance);
  double size = 0; // of a macrocell, as a ray may pass it
  for (int a = 0; a < 3; ++a)
    size = std::max(size, grid_.size[a]);
  const double share = tolerance * (size > 0 ? size / diagonal : 1.0);
  level_.resize(std::size_t(grid_.count()));
  constexpr int most = most_refined + most_coarsened;
  int lowest = most;
  bool any = false;
  for (std::int64_t i = 0; i < grid_.count(); ++i) {
    const Macrocells::Range& range = cells.range(i);
    int level = most;
    if (range.lower <= range.upper) {
      const double varies = variation.over(range.lower, range.upper, cells.has_nan(i));
      const double c = cells.smallest_cell(i);
      const auto step_of = [&](int at) { return nominal_step * std::pow(3.0, at - most_refined); };
      const auto holds = [&](int at) {
        const double h = step_of(at);
        return h * std::min(1.0, c > 0 ? h / c : 1.0) * varies <= share;
      };
      while (level > 0 && !holds(level))
        --level;
      unheld_ +=
          !holds(level) || step_of(level) * variation.step_within(range.lower, range.upper) > share;
      any = true;
      lowest = std::min(lowest, level);
    }
    level_[std::size_t(i)] = std::uint8_t(level);
  }
  if (!any)
    lowest = most_refined;
  for (std::uint8_t& level : level_)
    level = std::uint8_t(level - lowest);
  base_step_ = nominal_step * std::pow(3.0, lowest - most_refined);
  count_ = most - lowest + 1;
}

} // namespace insitu::render
