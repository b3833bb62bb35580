#include <algorithm>
#include <bit>
#include <cmath>

#include "render/volume/volume.h"
#include "render/volume/volume_scratch.h"

/// What samples add to their rays.
namespace insitu::render {

using math::Vec3d;

namespace {

/// Bits [begin, end) of 32.
std::uint32_t bits_between(std::int64_t begin, std::int64_t end) {
  const auto below = [](std::int64_t n) {
    return n <= 0 ? 0u : n >= 32 ? ~std::uint32_t(0) : (std::uint32_t(1) << n) - 1;
  };
  return below(end) & ~below(begin);
}

} // namespace

/// Samples of a ray from `first` on. locations: may be null unless colours are lit; levels: unless
/// steps have some.
void VolumeMarcher::gather_stretch(RayState& ray, Gathered& last, std::int64_t first,
                                   std::uint32_t wanted, const query::ValueSample* samples,
                                   const query::Location* locations,
                                   const std::uint8_t* levels) const {
  if (is_plain() && ray.next_hit == ray.hits.size() && !ray.keeps_stretches)
    return gather_plainly(ray, first, wanted, samples);
  for (std::uint32_t rest = wanted; rest && !ray.is_saturated(); rest &= rest - 1) {
    const int k = std::countr_zero(rest);
    const auto [cell, value] = samples[k];
    gather(ray, last, first + k, value, shader_ ? locations[k] : query::Location{cell, {}},
           levels_ ? levels[k] : 0);
  }
}

/// What gather() makes of samples that nothing but the function says anything about.
void VolumeMarcher::gather_plainly(RayState& ray, std::int64_t first, std::uint32_t wanted,
                                   const query::ValueSample* samples) const {
  const Classifier& classify = classifiers_[0];
  Rgba color = rgba_of(ray.color, 0.0f);
  float alpha = ray.alpha;
  // Those whose stretch is a step: all but one or two at either end.
  const std::uint32_t inner = bits_between(ray.first + 2 - first, ray.end - 2 - first);
  for (std::uint32_t rest = wanted; rest && alpha < saturated; rest &= rest - 1) {
    const int k = std::countr_zero(rest);
    const auto [cell, value] = samples[k];
    if (cell < 0)
      continue;
    const Rgba sample = classify.rgba(value);
    const float opacity = sample[3];
    if (!(opacity > 0))
      continue;
    if ((inner >> k & 1) && (alpha >= 0.5f || alpha + (1.0f - alpha) * opacity < 0.5f)) {
      blend_behind(color, alpha, sample, opacity);
      continue;
    }
    ray.color = color_of(color); // a stretch of its own, or where the depth is
    ray.alpha = alpha;
    add_value(ray, stretch(ray, first + k, 1), value, {cell, {}}, 0);
    color = rgba_of(ray.color, 0.0f);
    alpha = ray.alpha;
  }
  ray.color = color_of(color);
  ray.alpha = alpha;
}

/// The stretch of the ray that a sample stands for: its own of the lattice, `stride` steps from
/// `begin` on, and at either end of what the bounds or clips leave of the ray, all up to there.
Stretch VolumeMarcher::stretch(const RayState& ray, std::int64_t begin, std::int64_t stride) const {
  const double from = double(begin) * step_, to = double(begin + stride) * step_;
  Stretch whole{ray.near, ray.far};
  if (clipped_)
    for (const Stretch& stay : ray.stays)
      if (stay.from <= 0.5 * (from + to) && 0.5 * (from + to) <= stay.to)
        whole = {std::max(whole.from, stay.from), std::min(whole.to, stay.to)};
  return {from - 0.5 * step_ < whole.from ? whole.from : from,
          to + 0.5 * step_ > whole.to ? whole.to : to};
}

void VolumeMarcher::gather(RayState& ray, Gathered& last, std::int64_t index, double value,
                           const query::Location& at, int level) const {
  if (!preintegration_) {
    if (at)
      add_value(ray, stretch(ray, index, StepLevels::stride(level)), value, at, level);
    return;
  }
  if (last.index >= 0 && (index != last.index + 1 || !at))
    finish(ray, last);
  if (!at || ray.is_saturated())
    return;
  const double middle = (double(index) + 0.5) * step_;
  const Preintegration::Place place = preintegration_->place(value, last.place);
  if (last.index < 0 || value - value != 0 || last.place.value - last.place.value != 0) {
    finish(ray, last);
    if (!ray.is_saturated())
      add_value(ray, {stretch(ray, index, 1).from, middle}, value, at, 0);
  } else {
    ++ray.integrals;
    ColorSample segment = (*preintegration_)(last.place, place);
    if (shader_ && segment.alpha > 0)
      light(ray, at, segment.color);
    if (ray.next_hit < ray.hits.size())
      add(ray, {middle - step_, middle}, segment, at.cell);
    else if (segment.alpha > 0)
      ray.blend_stretch(segment.color, segment.alpha, middle - step_, middle, at.cell);
  }
  last = {index, place, at};
}

/// What is behind the last sample, of its value.
void VolumeMarcher::finish(RayState& ray, Gathered& last) const {
  if (last.index >= 0 && !ray.is_saturated())
    add_value(ray, {(double(last.index) + 0.5) * step_, stretch(ray, last.index, 1).to},
              last.place.value, last.at, 0);
  last.index = -1;
}

void VolumeMarcher::add_sample(RayState& ray, const Stretch& stretch, const query::Location& at,
                               int level) const {
  add_value(ray, stretch, field_.at(sampler_.mesh(), at), at, level);
}

/// A stretch of one value.
void VolumeMarcher::add_value(RayState& ray, const Stretch& stretch, double value,
                              const query::Location& at, int level) const {
  ColorSample sample = classifiers_[std::size_t(level)](value);
  if (sample.alpha > 0) {
    const double length = stretch.to - stretch.from;
    // The tables are for a whole step; the first and the last sample have stretches of their own.
    if (std::fabs(length - double(StepLevels::stride(level)) * step_) > 1e-9 * step_) {
      const double opacity = function_.opacity(value);
      sample.alpha = opacity < 1
                         ? float(-std::expm1(length / unit_distance_ * std::log1p(-opacity)))
                         : float(length > 0);
    }
    if (shader_)
      light(ray, at, sample.color);
  }
  add(ray, stretch, sample, at.cell);
}

/// Of the field, at a location of this process.
Vec3d VolumeMarcher::gradient(const query::Location& at) const {
  mesh::CellVertices cell;
  mesh::gather(sampler_.mesh(), at.cell, cell);
  double values[8];
  for (int v = 0; v < cell.count; ++v)
    values[v] = field_.load(cell.piece, cell.ids[v]);
  return cells::gradient(cell.shape, cell.x, values, at.parametric);
}

Vec3d VolumeMarcher::place(const query::Location& at) const {
  mesh::CellVertices cell;
  mesh::gather(sampler_.mesh(), at.cell, cell);
  double weight[8] = {};
  cells::shape_functions(cell.shape, at.parametric, weight);
  Vec3d place;
  for (int v = 0; v < cell.count; ++v)
    place += weight[v] * cell.x[v];
  return place;
}

/// As a surface across the gradient would be, seen from the side that the viewer is on.
std::optional<SurfacePoint> VolumeMarcher::lit_point(const Ray& view, const Vec3d& gradient,
                                                     const Vec3d& place) {
  Vec3d normal = gradient;
  const double most = std::max({std::fabs(normal.x), std::fabs(normal.y), std::fabs(normal.z)});
  if (!(most > 0) || !std::isfinite(most))
    return std::nullopt;  // flat: there is no side to be lit from
  normal = normal / most; // squares of 1e-300 are none
  normal = normal / std::sqrt(dot(normal, normal));
  if (dot(normal, view.direction) > 0)
    normal = -normal;
  return SurfacePoint{place, normal, -view.direction};
}

void VolumeMarcher::light(RayState& ray, const query::Location& at, Color& color) const {
  ++ray.lit;
  if (takes_part_ && is_lit_by_place()) {
    const Vec3d& light = at.parametric;
    color = {float(light.x) * color.r, float(light.y) * color.g, float(light.z) * color.b};
    return;
  }
  const auto point = takes_part_ ? lit_point(ray.ray, at.parametric, {})
                                 : lit_point(ray.ray, gradient(at), place(at));
  if (!point)
    return;
  SurfaceCounts sent;
  const Color sum = (*shader_)(
      *point,
      [&](const Ray& to, double t_max) { return surfaces_ ? surfaces_->open(to, t_max) : 1.0; },
      sent);
  ray.shadow_rays += sent.shadow_rays;
  color = {sum.r * color.r, sum.g * color.g, sum.b * color.b};
}

/// Adds what a stretch gathers. Hits within it part it.
void VolumeMarcher::add(RayState& ray, const Stretch& stretch, const ColorSample& sample,
                        std::int64_t cell) const {
  double from = stretch.from;
  const auto blend = [&](double to) {
    if (!(to > from) || !(sample.alpha > 0))
      return;
    const bool whole = from == stretch.from && to == stretch.to;
    const double part = (to - from) / (stretch.to - stretch.from);
    ray.blend_stretch(sample.color, whole ? sample.alpha : Classifier::partial(sample.alpha, part),
                      from, to, cell);
  };
  while (ray.next_hit < ray.hits.size() && ray.hits[ray.next_hit].t < stretch.to) {
    const double upto = std::clamp(ray.hits[ray.next_hit].t, from, stretch.to);
    blend(upto);
    from = upto;
    if (ray.is_saturated())
      return;
    ray.blend_next_hit();
    if (ray.is_saturated())
      return;
  }
  blend(stretch.to);
}

} // namespace insitu::render
