#include "render/volume/volume_shadow.h"

#include <algorithm>
#include <cmath>

#include "accel/tree/tree.h"

namespace insitu::render {

namespace {

constexpr double dark = 1.0 / 4096; // less does not show

} // namespace

VolumeShadow::VolumeShadow(const query::Sampler& sampler, const VolumeSettings& settings,
                           double density, const Majorants* majorants,
                           const std::vector<Clip>& clips)
    : sampler_(sampler), field_(settings.field), step_(ray_step(sampler, settings)),
      classifier_(settings.function, step_ * density, unit_distance_of(sampler, settings)),
      majorants_(majorants), clips_(clips), low_(sampler.tree().bounds_min()),
      high_(sampler.tree().bounds_max()) {
  options_.accuracy = settings.accuracy;
  options_.coordinates = settings.field.field.association != INSITU_CELL;
}

double VolumeShadow::through(const Ray& ray, double t_max, std::int64_t& samples) const {
  double light = 1;
  const std::optional<Stretch> in = stretch_in_box(ray, low_, high_);
  if (!in)
    return light;
  const double near = std::max(0.0, in->from), far = std::min(t_max, in->to);
  if (!(near < far) || !std::isfinite(far))
    return light;
  thread_local std::vector<Stretch> stays; // kept for the thread's life
  clip_ray(clips_, ray, near, far, stays);
  for (const Stretch& stay : stays) {
    bool goes_on = true;
    if (!majorants_)
      goes_on = follow(ray, stay.from, stay.to, light, samples);
    else
      for_each_macrocell(
          majorants_->grid(), ray, stay.from, stay.to, [&](std::int64_t m, double from, double to) {
            return goes_on = majorants_->opacity(m) <= 0 || follow(ray, from, to, light, samples);
          });
    if (!goes_on)
      break;
  }
  return light > dark ? light : 0;
}

/// The samples in (from, to]; false: no light is left.
bool VolumeShadow::follow(const Ray& ray, double from, double to, double& light,
                          std::int64_t& samples) const {
  constexpr std::int64_t most = 32;
  math::Vec3d points[most];
  query::Location found[most];
  const auto end = std::int64_t(std::ceil(to / step_ - 0.5));
  for (auto first = std::int64_t(std::ceil(from / step_ - 0.5)); first < end; first += most) {
    const auto count = std::size_t(std::min(most, end - first));
    for (std::size_t i = 0; i < count; ++i)
      points[i] = ray.origin + ((double(first) + double(i) + 0.5) * step_) * ray.direction;
    sampler_.locate_serial({points, count}, {found, count}, options_);
    samples += std::int64_t(count);
    for (std::size_t i = 0; i < count; ++i)
      if (found[i])
        light *= 1 - double(classifier_(field_.at(sampler_.mesh(), found[i])).alpha);
    if (!(light > dark))
      return false;
  }
  return true;
}

} // namespace insitu::render
