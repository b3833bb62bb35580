#include "render/color/transfer_function.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"

namespace insitu::render {

namespace {

[[noreturn]] void refuse(const std::string& message) {
  throw core::Error(INSITU_ERROR_ARGUMENT, "transfer function: " + message);
}

float corrected(double opacity, double exponent) {
  return opacity >= 1.0 ? 1.0f : float(-std::expm1(exponent * std::log1p(-opacity)));
}

} // namespace

TransferFunction::TransferFunction(ColorMap colors, double low, double high,
                                   std::vector<OpacityPoint> opacity)
    : colors_(std::move(colors)), low_(low), high_(high), opacity_(std::move(opacity)) {
  if (!std::isfinite(low) || !std::isfinite(high) || low > high)
    refuse("the range must be finite and ascending, [" + std::to_string(low) + ", " +
           std::to_string(high) + "] given");
  if (scale() == Scale::log && !(low > 0))
    refuse("a logarithmic range must begin above 0, [" + std::to_string(low) + ", " +
           std::to_string(high) + "] given");
  if (opacity_.empty())
    opacity_ = {{low, 0.0}, {high, 1.0}};
  for (std::size_t i = 0; i < opacity_.size(); ++i) {
    const OpacityPoint& p = opacity_[i];
    if (!std::isfinite(p.value))
      refuse("the value of opacity point " + std::to_string(i) + " is not finite");
    if (!(p.opacity >= 0.0 && p.opacity <= 1.0))
      refuse("opacity point " + std::to_string(i) + " is " + std::to_string(p.opacity) +
             "; 0 to 1 expected");
    if (i > 0 && p.value < opacity_[i - 1].value)
      refuse("opacity point " + std::to_string(i) + " at " + std::to_string(p.value) +
             " lies below the one before it at " + std::to_string(opacity_[i - 1].value));
  }
}

Color TransferFunction::color(double value) const {
  if (std::isnan(value))
    return colors_.nan_color();
  if (value >= high_)
    return value > high_ && colors_.above() ? *colors_.above() : colors_.at(1.0);
  if (value <= low_)
    return value < low_ && colors_.below() ? *colors_.below() : colors_.at(0.0);
  if (scale() == Scale::log)
    return colors_.at((std::log(value) - std::log(low_)) / (std::log(high_) - std::log(low_)));
  return colors_.at((value - low_) / (high_ - low_));
}

double TransferFunction::value_between(double from, double to, double u) const {
  if (scale() == Scale::log && from > 0 && to > 0)
    return std::exp((1 - u) * std::log(from) + u * std::log(to));
  return from + (to - from) * u;
}

double TransferFunction::opacity_between(const OpacityPoint& a, const OpacityPoint& b,
                                         double value) const {
  const double u =
      scale() == Scale::log && a.value > 0
          ? (std::log(value) - std::log(a.value)) / (std::log(b.value) - std::log(a.value))
          : (value - a.value) / (b.value - a.value);
  return a.opacity + (b.opacity - a.opacity) * u;
}

double TransferFunction::opacity(double value) const {
  if (std::isnan(value))
    return nan_opacity_;
  const auto above = std::upper_bound(opacity_.begin(), opacity_.end(), value,
                                      [](double v, const OpacityPoint& p) { return v < p.value; });
  if (above == opacity_.begin())
    return opacity_.front().opacity;
  if (above == opacity_.end())
    return opacity_.back().opacity;
  return opacity_between(*(above - 1), *above, value);
}

double TransferFunction::opacity_below(double value) const {
  const auto above = std::lower_bound(opacity_.begin(), opacity_.end(), value,
                                      [](const OpacityPoint& p, double v) { return p.value < v; });
  if (above == opacity_.begin())
    return opacity_.front().opacity;
  if (above == opacity_.end())
    return opacity_.back().opacity;
  return opacity_between(*(above - 1), *above, value);
}

double TransferFunction::max_opacity(double low, double high) const {
  double most = std::max(opacity(low), opacity(high));
  auto p = std::partition_point(opacity_.begin(), opacity_.end(),
                                [&](const OpacityPoint& q) { return q.value <= low; });
  // Of points of one value, the first is the limit from below and the last the value itself; those
  // between are never taken.
  while (p != opacity_.end() && p->value <= high) {
    auto last = p;
    while (last + 1 != opacity_.end() && (last + 1)->value == p->value)
      ++last;
    most = std::max({most, p->opacity, last->opacity});
    p = last + 1;
  }
  return most;
}

ColorTable::ColorTable(const TransferFunction& function)
    : low_(function.low()), high_(function.high()), log_(function.scale() == Scale::log) {
  const ColorMap& colors = function.colors();
  start_ = place_of(low_, log_);
  const double extent = place_of(high_, log_) - start_;
  scale_ = extent > 0 ? size / extent : 0.0;
  while (extent > 0 && extent * scale_ < size) // what is above the range must be so here too
    scale_ = std::nextafter(scale_, HUGE_VAL);
  color_.reserve(size + 1);
  for (int i = 0; i <= size; ++i) {
    const double u = double(i) / size;
    color_.push_back(log_ && i > 0 && i < size && extent > 0
                         ? function.color(value_at(start_ + u * extent, true))
                         : colors.at(u));
  }
  below_ = colors.below().value_or(color_.front());
  above_ = colors.above().value_or(color_.back());
}

/// What rounding puts beyond the table has the colours of its ends.
Color ColorTable::at_end(double value, double at) const {
  if (value > high_)
    return above_;
  if (value < low_)
    return below_;
  return value >= high_ || at > 0.0 ? color_.back() : color_.front();
}

Classifier::Classifier(const TransferFunction& function, double step, double unit_distance)
    : colors_(function) {
  if (!(step > 0.0) || !(unit_distance > 0.0))
    refuse("the ray step and the unit distance must be positive, " + std::to_string(step) +
           " and " + std::to_string(unit_distance) + " given");
  const double exponent = step / unit_distance;
  const std::vector<OpacityPoint>& points = function.opacity_points();
  int sloping = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    sloping += points[i].opacity != points[i - 1].opacity && points[i].value > points[i - 1].value;
  const int each = std::max(64, table_size / std::max(1, sloping));
  for (std::size_t i = 1; i < points.size(); ++i) {
    const OpacityPoint &p = points[i - 1], &q = points[i];
    if (!(p.value < q.value))
      continue;
    const int count = p.opacity == q.opacity ? 1 : each;
    const bool log = function.scale() == Scale::log && p.value > 0;
    const double start = place_of(p.value, log), extent = place_of(q.value, log) - start;
    stretches_.push_back({p.value, start, count / extent, int(alpha_.size()), count, log});
    for (int k = 0; k <= count; ++k) {
      const double u = double(k) / count;
      alpha_.push_back(corrected(log && k > 0 && k < count
                                     ? function.opacity(value_at(start + u * extent, true))
                                     : p.opacity + (q.opacity - p.opacity) * u,
                                 exponent));
    }
  }
  const float last = corrected(points.back().opacity, exponent);
  stretches_.push_back(
      {points.back().value, points.back().value, 0.0, int(alpha_.size()), 1, false});
  alpha_.insert(alpha_.end(), 2, last);
  below_ = corrected(points.front().opacity, exponent);
  // Twice what Majorants call nothing: linear between entries is a little above the curve.
  least_ = corrected(2 * TransferFunction::invisible, exponent);
  nan_color_ = function.colors().nan_color();
  nan_alpha_ = corrected(function.nan_opacity(), exponent);
  if (below_ < least_)
    below_ = 0;
  set_joint();
}

/// Both together serve where no opacity point lies between two entries, none makes opacity jump at
/// them, to which a value beside may be rounded, and opacity a third of the way on is that of a
/// line.
void Classifier::set_joint() {
  constexpr int n = ColorTable::size;
  joint_.resize(n + 1);
  is_joint_.assign(n, 0);
  double left = colors_.value_of(0);
  float a = alpha(left);
  for (int i = 0; i <= n; ++i) {
    joint_[std::size_t(i)] = rgba_of(colors_.entry(i), a);
    if (i == n)
      break;
    const double right = colors_.value_of(i + 1), width = right - left;
    const auto just_below = [&](double v) {
      return std::min(v - 1e-6 * width, std::nextafter(v, -HUGE_VAL));
    };
    const double before = just_below(left), end = just_below(right), third = left + width / 3;
    const float b = alpha(right), allowed = 1e-5f * std::max(a, b);
    const auto is_near = [&](double value, float expected) {
      return std::fabs(alpha(value) - expected) <= allowed;
    };
    if (left < end && stretch_of(left) == stretch_of(end) && is_near(before, a) &&
        is_near(end, b)) {
      const double w = colors_.place(third) - i;
      is_joint_[std::size_t(i)] = is_near(third, float((1 - w) * a + w * b));
    }
    left = right;
    a = b;
  }
}

std::size_t Classifier::stretch_of(double value) const {
  const auto above = std::upper_bound(stretches_.begin(), stretches_.end(), value,
                                      [](double v, const Stretch& s) { return v < s.value; });
  return std::size_t(above - stretches_.begin()) - 1;
}

float Classifier::partial(float alpha, double fraction) {
  return corrected(double(alpha), fraction);
}

} // namespace insitu::render
