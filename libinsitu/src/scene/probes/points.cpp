#include "scene/probes/points.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace insitu::scene {
namespace {

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>; // clang 14 does not deduce it

/// Where step `index` of `count` lies from 0 to 1; a single one in the middle.
double fraction(std::int64_t index, std::int64_t count) {
  return count == 1 ? 0.5 : static_cast<double>(index) / static_cast<double>(count - 1);
}

/// Exactly a and b at the ends, and without overflow between far ones.
double blend(double a, double b, double t) {
  return a == b ? a : (1 - t) * a + t * b;
}

math::Vec3d blend(const math::Vec3d& a, const math::Vec3d& b, double t) {
  return {blend(a.x, b.x, t), blend(a.y, b.y, t), blend(a.z, b.z, t)};
}

double leg_length(const math::Vec3d& a, const math::Vec3d& b) {
  return std::hypot(b.x - a.x, b.y - a.y);
}

math::Vec3d on_path(const Curtain& curtain, std::int64_t station) {
  double left = distance_at(curtain, station);
  const std::vector<math::Vec3d>& through = curtain.through;
  if (station == curtain.count - 1) // whatever the sum's rounding
    return through.back();
  for (std::size_t i = 0; i + 1 < through.size(); ++i) {
    const double leg = leg_length(through[i], through[i + 1]);
    if (left < leg || i + 2 == through.size())
      return blend(through[i], through[i + 1], std::min(left / leg, 1.0));
    left -= leg;
  }
  return through.front(); // of one place: not made by the reader
}

math::Vec3d in_ball(const Sphere& ball, std::int64_t index) {
  constexpr double plastic = 1.32471795724474602596; // the real root of p^3 = p + 1
  const auto i = static_cast<double>(index);
  const auto sequence = [i](double step) {
    const double value = 0.5 + i * step;
    return value - std::floor(value);
  };
  const double radius = ball.radius * std::cbrt((i + 0.5) / static_cast<double>(ball.count));
  const double up = 1 - 2 * sequence(1 / plastic);
  const double across = std::sqrt(1 - up * up);
  const double angle = 2 * std::numbers::pi * sequence(1 / (plastic * plastic));
  return ball.center + radius * math::Vec3d{across * std::cos(angle), across * std::sin(angle), up};
}

} // namespace

std::int64_t point_count(const PointSource& source) {
  return std::visit(
      Overloaded{
          [](const PointList& s) { return static_cast<std::int64_t>(s.points.size()); },
          [](const PointFile&) { return std::int64_t{0}; },
          [](const Plane& s) { return s.counts[0] * s.counts[1]; },
          [](const Box& s) { return s.counts[0] * s.counts[1] * s.counts[2]; },
          [](const Curtain& s) { return s.count * static_cast<std::int64_t>(s.levels.size()); },
          [](const auto& s) { return s.count; }},
      source);
}

double path_length(const Curtain& curtain) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < curtain.through.size(); ++i)
    length += leg_length(curtain.through[i], curtain.through[i + 1]);
  return length;
}

double distance_at(const Curtain& curtain, std::int64_t index) {
  return path_length(curtain) * fraction(index, curtain.count);
}

math::Vec3d point_at(const PointSource& source, std::int64_t index) {
  return std::visit(
      Overloaded{[&](const PointList& s) { return s.points[static_cast<std::size_t>(index)]; },
                 [&](const PointFile&) { return math::Vec3d{}; },
                 [&](const Line& s) { return blend(s.from, s.to, fraction(index, s.count)); },
                 [&](const Transect& s) { return blend(s.from, s.to, fraction(index, s.count)); },
                 [&](const Plane& s) {
                   return s.origin + fraction(index % s.counts[0], s.counts[0]) * s.u +
                          fraction(index / s.counts[0], s.counts[1]) * s.v;
                 },
                 [&](const Box& s) {
                   const std::int64_t row = index / s.counts[0];
                   return math::Vec3d{
                       blend(s.min.x, s.max.x, fraction(index % s.counts[0], s.counts[0])),
                       blend(s.min.y, s.max.y, fraction(row % s.counts[1], s.counts[1])),
                       blend(s.min.z, s.max.z, fraction(row / s.counts[1], s.counts[2]))};
                 },
                 [&](const Sphere& s) { return in_ball(s, index); },
                 [&](const Curtain& s) {
                   const auto levels = static_cast<std::int64_t>(s.levels.size());
                   math::Vec3d point = on_path(s, index / levels);
                   point.z = s.levels[static_cast<std::size_t>(index % levels)];
                   return point;
                 }},
      source);
}

} // namespace insitu::scene
