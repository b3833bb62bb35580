#include "render/color/preintegration.h"

#include <algorithm>
#include <cmath>

namespace insitu::render {

namespace {

constexpr double deepest = 40; // exp(-40) is nothing to a float, and 1 - it is 1 to a double

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
    return Integral{t, {t * double(c.r), t * double(c.g), t * double(c.b)}};
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
    parts_.push_back({low, each / width, int(knots_.size()), each});
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
        knot.sum.t += weight * d.t;
        for (int c = 0; c < 3; ++c)
          knot.sum.k[c] += weight * d.k[c];
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
      limit(q.sum.t - p.sum.t, p.after.t, q.before.t);
      for (int c = 0; c < 3; ++c)
        limit(q.sum.k[c] - p.sum.k[c], p.after.k[c], q.before.k[c]);
    }
  }
  knot.after = of(points.back().opacity, function.color(HUGE_VAL));
  parts_.push_back({breaks.back(), 0, int(knots_.size()), 0});
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

std::size_t Preintegration::part_of(double value) const {
  const auto above = std::upper_bound(parts_.begin(), parts_.end(), value,
                                      [](double v, const Part& p) { return v < p.value; });
  return std::size_t(above - parts_.begin());
}

/// part: part_of(value); 0 is all below the first break.
Preintegration::Integral Preintegration::at(double value, std::size_t part) const {
  const Part& p = parts_[part == 0 ? 0 : part - 1];
  Integral sum;
  if (part == 0 || p.count == 0) { // linear to either side
    const Integral& slope = part == 0 ? below_ : knots_.back().after;
    const Integral& from = knots_[std::size_t(p.first)].sum;
    const double d = value - p.value;
    sum.t = from.t + d * slope.t;
    for (int c = 0; c < 3; ++c)
      sum.k[c] = from.k[c] + d * slope.k[c];
    return sum;
  }
  const double x = (value - p.value) * p.scale;
  const int i = x > 0 ? (x < p.count ? int(x) : p.count - 1) : 0;
  const double u = std::min(std::max(x - i, 0.0), 1.0), w = 1 / p.scale;
  const Knot &a = knots_[std::size_t(p.first + i)], &b = *(&a + 1);
  const double rise = u * u * (3 - 2 * u), from = u * (1 - u) * (1 - u) * w,
               to = u * u * (1 - u) * w;
  const auto cubic = [&](double ya, double yb, double da, double db) {
    return ya + ((yb - ya) * rise + (da * from - db * to)); // exactly ya where nothing rises
  };
  sum.t = cubic(a.sum.t, b.sum.t, a.after.t, b.before.t);
  for (int c = 0; c < 3; ++c)
    sum.k[c] = cubic(a.sum.k[c], b.sum.k[c], a.after.k[c], b.before.k[c]);
  return sum;
}

ColorSample Preintegration::operator()(double a, double b) const {
  const std::size_t part_a = part_of(a), part_b = part_of(b);
  const double difference = b - a;
  // Within an interval the middle's value does, and integrals would cancel.
  const double scale = part_a == 0 ? 0.0 : parts_[part_a - 1].scale;
  if ((part_a == part_b && std::fabs(difference) * scale < 0.5) ||
      std::fabs(difference) <= 1e-9 * std::max(std::fabs(a), std::fabs(b)) ||
      !std::isfinite(difference))
    return classifier_(0.5 * a + 0.5 * b);
  const Integral from = at(a, part_a), to = at(b, part_b);
  const double rise = to.t - from.t;
  const double depth = exponent_ * (rise / difference);
  ColorSample sample;
  if (!(depth > least_))
    return sample;
  sample.alpha = float(-std::expm1(-depth));
  sample.color = {float((to.k[0] - from.k[0]) / rise), float((to.k[1] - from.k[1]) / rise),
                  float((to.k[2] - from.k[2]) / rise)};
  return sample;
}

} // namespace insitu::render
