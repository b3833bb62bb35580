#include "render/color/preintegration.h"

#include <algorithm>
#include <cmath>

namespace insitu::render {

namespace {

constexpr double deepest = 40; // exp(-40) is nothing to a float, and 1 - it is 1 to a double

/// 1 - exp(-depth), to 1e-11 of itself. Of the thin stretches, which nearly all are, by Taylor's
/// series.
double absorbed(double depth) {
  if (depth > 0.25)
    return -std::expm1(-depth);
  const double square = depth * depth;
  const double last =
      1.0 / 120 - depth * (1.0 / 720) + square * (1.0 / 5040 - depth * (1.0 / 40320));
  return depth * (1 - 0.5 * depth + square * (1.0 / 6 - depth * (1.0 / 24) + square * last));
}

} // namespace

Preintegration::Preintegration(const TransferFunction& function, double step, double unit_distance,
                               const core::CountedAllocator<char>& counted)
    : classifier_(function, step, unit_distance), parts_(counted), knots_(counted),
      exponent_(step / unit_distance), least_(2 * TransferFunction::invisible * exponent_) {
  const std::vector<OpacityPoint>& points = function.opacity_points();
  std::vector<double> breaks{function.low(), function.high()};
  for (const OpacityPoint& p : points)
    breaks.push_back(p.value);
  std::sort(breaks.begin(), breaks.end());
  // Tables are even in the value: on a logarithmic scale at least three for each decade.
  if (function.scale() == Scale::log) {
    const double low = *std::upper_bound(breaks.begin(), breaks.end(), 0.0), high = breaks.back();
    const int count = int(
        std::min<double>(most_parts_of_log, std::ceil(3 * (std::log10(high) - std::log10(low)))));
    for (int i = 1; i < count; ++i)
      breaks.push_back(function.value_between(low, high, double(i) / count));
    std::sort(breaks.begin(), breaks.end());
  }
  breaks.erase(std::unique(breaks.begin(), breaks.end()), breaks.end());
  const double most = deepest * std::max(1.0, 1 / exponent_);
  const auto extinction = [&](double opacity) {
    return opacity >= 1 ? most : std::min(most, -std::log1p(-opacity));
  };
  const auto of = [&](double opacity, const Color& c) {
    const double t = extinction(opacity);
    return Integral{{t, t * double(c.r), t * double(c.g), t * double(c.b)}};
  };
  below_ = of(points.front().opacity, function.color(-HUGE_VAL));
  const int each = knots_in(breaks.size());
  parts_.reserve(breaks.size());
  knots_.reserve((breaks.size() - 1) * std::size_t(each + 1) + 1);
  Knot knot;
  for (std::size_t b = 1; b < breaks.size(); ++b) {
    const double low = breaks[b - 1], width = breaks[b] - low;
    const double a0 = function.opacity(low), a1 = function.opacity_below(breaks[b]);
    const bool log = function.scale() == Scale::log && low > 0;
    // Just within its ends, at which another opacity and another colour may begin.
    const double first = std::nextafter(low, HUGE_VAL), last = std::nextafter(breaks[b], -HUGE_VAL);
    const auto inside = [&](double u) {
      const double value = std::max(first, std::min(low + u * width, last));
      return of(log ? function.opacity(value) : a0 + u * (a1 - a0), function.color(value));
    };
    parts_.push_back({low, each / width, 1 / (each / width), int(knots_.size()), each});
    for (int i = 0; i <= each; ++i) {
      knot.after = knot.before = inside(double(i) / each);
      knots_.push_back(knot);
      if (i == each)
        break;
      // Gauss's rule of three points: exact for polynomials up to degree 5.
      for (const auto& [x, w] : {std::pair{-0.7745966692414834, 5.0 / 18},
                                 {0.0, 8.0 / 18},
                                 {0.7745966692414834, 5.0 / 18}}) {
        const Integral d = inside((i + 0.5 + 0.5 * x) / each);
        const double weight = w * width / each;
        for (int c = 0; c < 4; ++c)
          knot.sum.of[c] += weight * d.of[c];
      }
    }
    // Cubics stay monotone with slopes of at most three times the mean's (Fritsch, Carlson 1980).
    for (int i = 0; i < each; ++i) {
      Knot &p = knots_[knots_.size() - std::size_t(each - i + 1)], &q = *(&p + 1);
      const auto limit = [&](double rise, double& from, double& to) {
        const double steepest = 3 * rise * each / width;
        from = std::min(from, steepest);
        to = std::min(to, steepest);
      };
      for (int c = 0; c < 4; ++c)
        limit(q.sum.of[c] - p.sum.of[c], p.after.of[c], q.before.of[c]);
    }
  }
  knot.after = of(points.back().opacity, function.color(HUGE_VAL));
  parts_.push_back({breaks.back(), 0, 0, int(knots_.size()), 0});
  knots_.push_back(knot);
}

std::int64_t Preintegration::most_bytes(int opacity_points, Scale scale) {
  const int most = opacity_points + 2 + (scale == Scale::log ? most_parts_of_log : 0);
  std::int64_t bytes = 0; // not more for more breaks, step by step
  for (int breaks = 1; breaks <= most; ++breaks)
    bytes =
        std::max(bytes, breaks * std::int64_t(sizeof(Part)) +
                            (std::int64_t(breaks - 1) * (knots_in(std::size_t(breaks)) + 1) + 1) *
                                std::int64_t(sizeof(Knot)));
  return bytes;
}

std::int64_t Preintegration::bytes() const {
  return std::int64_t(parts_.capacity() * sizeof(Part) + knots_.capacity() * sizeof(Knot));
}

std::size_t Preintegration::part_of(double value, std::size_t likely) const {
  if (likely > 0 && likely < parts_.size() && parts_[likely - 1].value <= value &&
      value < parts_[likely].value)
    return likely;
  const auto above = std::upper_bound(parts_.begin(), parts_.end(), value,
                                      [](double v, const Part& p) { return v < p.value; });
  return std::size_t(above - parts_.begin());
}

/// part: the value's; 0 is all below the first break.
void Preintegration::add_up(double value, std::size_t part, Integral& sum) const {
  const Part& p = parts_[part == 0 ? 0 : part - 1];
  if (part == 0 || p.count == 0) { // linear to either side
    const Integral& slope = part == 0 ? below_ : knots_.back().after;
    const Integral& from = knots_[std::size_t(p.first)].sum;
    const double d = value - p.value;
    for (int c = 0; c < 4; ++c)
      sum.of[c] = from.of[c] + d * slope.of[c];
    return;
  }
  const double x = (value - p.value) * p.scale;
  const int i = x > 0 ? (x < p.count ? int(x) : p.count - 1) : 0;
  const double u = std::min(std::max(x - i, 0.0), 1.0), w = p.width;
  const Knot &a = knots_[std::size_t(p.first + i)], &b = *(&a + 1);
  const double rise = u * u * (3 - 2 * u), from = u * (1 - u) * (1 - u) * w,
               to = u * u * (1 - u) * w;
  for (int c = 0; c < 4; ++c) // exactly a.sum where nothing rises
    sum.of[c] = a.sum.of[c] +
                ((b.sum.of[c] - a.sum.of[c]) * rise + (a.after.of[c] * from - b.before.of[c] * to));
}

Preintegration::Place Preintegration::place(double value, const Place& near) const {
  Place p;
  p.value = value;
  p.part = part_of(value, near.part);
  add_up(value, p.part, p.sum);
  return p;
}

ColorSample Preintegration::operator()(const Place& a, const Place& b) const {
  const double difference = b.value - a.value;
  // Within an interval the middle's value does, and integrals would cancel.
  const double scale = a.part == 0 ? 0.0 : parts_[a.part - 1].scale;
  if ((a.part == b.part && std::fabs(difference) * scale < 0.5) ||
      std::fabs(difference) <= 1e-9 * std::max(std::fabs(a.value), std::fabs(b.value)) ||
      !std::isfinite(difference))
    return classifier_(0.5 * a.value + 0.5 * b.value);
  const double rise = b.sum.of[0] - a.sum.of[0];
  const double depth = exponent_ * (rise / difference);
  ColorSample sample;
  if (!(depth > least_))
    return sample;
  sample.alpha = float(absorbed(depth));
  const double scaled = 1 / rise;
  const auto mean = [&](int c) { return float((b.sum.of[c] - a.sum.of[c]) * scaled); };
  sample.color = {mean(1), mean(2), mean(3)};
  return sample;
}

} // namespace insitu::render
