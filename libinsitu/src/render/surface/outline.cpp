#include "render/surface/outline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace insitu::render {

using math::Vec3d;

namespace {

Vec3d unit(const Vec3d& v) {
  return v / std::sqrt(dot(v, v));
}

} // namespace

Outline::Outline(const OutlineSettings& settings, const Camera& camera, int width, int height,
                 const Vec3d& low, const Vec3d& high, core::Memory& memory)
    : settings_(settings), position_(camera.position),
      forward_(unit(camera.look_at - camera.position)), right_(unit(cross(forward_, camera.up))),
      down_(cross(forward_, right_)), middle_x_(0.5 * (width - 1)), middle_y_(0.5 * (height - 1)),
      orthographic_(camera.orthographic_height > 0),
      lines_(core::CountedAllocator<Line>(memory, INSITU_MEMORY_FRAME)) {
  lines_.reserve(12 + settings.ticks.size());
  const double view = orthographic_ ? camera.orthographic_height
                                    : 2 * std::tan(camera.fov * std::numbers::pi / 360);
  pixel_ = view / height;
  const Vec3d diagonal = high - low;
  // Lines end before a viewer who stands on them.
  const double nearest = orthographic_ ? -HUGE_VAL : 1e-6 * std::sqrt(dot(diagonal, diagonal));
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 4; ++side) {
      Vec3d a = low;
      if (side & 1)
        a[(axis + 1) % 3] = high[(axis + 1) % 3];
      if (side & 2)
        a[(axis + 2) % 3] = high[(axis + 2) % 3];
      Vec3d b = a;
      b[axis] = high[axis];
      const double at_a = dot(a - position_, forward_), at_b = dot(b - position_, forward_);
      if (!(at_a > nearest) && !(at_b > nearest))
        continue;
      if (at_a < nearest || at_b < nearest)
        (at_a < nearest ? a : b) = a + ((nearest - at_a) / (at_b - at_a)) * (b - a);
      add_line(project(a), project(b));
    }
  for (const OutlineTick& tick : settings.ticks)
    if (dot(tick.at - position_, forward_) > nearest) {
      const Seen a = project(tick.at);
      add_line(a, {a.x + tick.by[0], a.y + tick.by[1], a.depth});
    }
}

void Outline::add_line(const Seen& a, const Seen& b) {
  const double reach = 0.5 * settings_.width + 0.5;
  lines_.push_back({a,
                    b,
                    {std::min(a.x, b.x) - reach, std::min(a.y, b.y) - reach},
                    {std::max(a.x, b.x) + reach, std::max(a.y, b.y) + reach}});
}

Outline::Seen Outline::project(const Vec3d& p) const {
  const Vec3d d = p - position_;
  const double depth = dot(d, forward_), scale = 1 / (orthographic_ ? pixel_ : depth * pixel_);
  return {scale * dot(d, right_), scale * dot(d, down_), depth};
}

void Outline::add(int column, int row, const Ray& ray, std::vector<SurfaceHit>& hits) const {
  const double x = column - middle_x_, y = row - middle_y_;
  for (const Line& line : lines_) {
    if (x < line.low[0] || x > line.high[0] || y < line.low[1] || y > line.high[1])
      continue;
    const double dx = line.b.x - line.a.x, dy = line.b.y - line.a.y;
    const double square = dx * dx + dy * dy;
    const double along = (x - line.a.x) * dx + (y - line.a.y) * dy;
    const double u = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
    const double distance = std::hypot(line.a.x + u * dx - x, line.a.y + u * dy - y);
    // A pixel's share, as if it were a disc that the line's border crosses straight.
    const double share =
        std::clamp(0.5 * settings_.width + 0.5 - distance, 0.0, std::min(1.0, settings_.width));
    if (!(share > 0))
      continue;
    // Evenly along a line in the image goes the depth, or in perspective its inverse.
    const double depth = orthographic_ ? (1 - u) * line.a.depth + u * line.b.depth
                                       : 1 / ((1 - u) / line.a.depth + u / line.b.depth);
    const double nearer =
        2 * std::max(1.0, settings_.width) * pixel_ * (orthographic_ ? 1.0 : depth);
    SurfaceHit hit;
    hit.t = (depth - nearer) / dot(ray.direction, forward_);
    hit.surface = -1;
    hit.opacity = float(share);
    hit.color = settings_.color;
    const auto after =
        std::find_if(hits.begin(), hits.end(), [&](const SurfaceHit& h) { return h.t > hit.t; });
    if (hit.t < 0 || (after == hits.end() && !hits.empty() && hits.back().opacity >= 1))
      continue;
    // Where lines meet they cover the same part of the pixel.
    if (after != hits.begin() && (after - 1)->surface == -1)
      (after - 1)->opacity = std::max((after - 1)->opacity, hit.opacity);
    else
      hits.insert(after, hit);
  }
}

} // namespace insitu::render
