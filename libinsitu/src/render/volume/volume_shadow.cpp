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
    : sampler_(sampler), located_(sampler.among_images()), field_(settings.field),
      step_(ray_step(sampler, settings)),
      classifier_(settings.function, step_ * density, unit_distance_of(sampler, settings)),
      majorants_(majorants), clips_(clips), box_(outer_bounds(sampler)) {
  options_.accuracy = settings.accuracy;
  options_.coordinates = settings.field.field.association != INSITU_CELL;
}

void VolumeShadow::take_part() {
  box_ = sampler_.facts().bounds;
  takes_part_ = true;
}

double VolumeShadow::through(const Ray& ray, double t_max, std::int64_t& samples) const {
  double light = 1;
  follow(ray, t_max, samples, [&](std::int64_t, std::span<const query::Location> found) {
    for (const query::Location& at : found)
      if (at)
        light *= 1 - double(classifier_(field_.at(sampler_.mesh(), at)).alpha);
    return light > dark;
  });
  return light > dark ? light : 0;
}

void VolumeShadow::claim(const Ray& ray, double t_max, std::int64_t own_cells,
                         std::vector<Claim>& claims, std::int64_t& samples) const {
  if (sampler_.tree().empty())
    return;
  follow(ray, t_max, samples, [&](std::int64_t first, std::span<const query::Location> found) {
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i] && found[i].cell < own_cells)
        if (const float alpha = classifier_(field_.at(sampler_.mesh(), found[i])).alpha; alpha > 0)
          claims.push_back({first + std::int64_t(i), found[i].cell, alpha});
    return true;
  });
}

double VolumeShadow::through(std::span<const Claim> claims) {
  double light = 1;
  for (const Claim& claim : claims)
    light *= 1 - double(claim.opacity);
  return light > dark ? light : 0;
}

void VolumeShadow::follow(const Ray& ray, double t_max, std::int64_t& samples,
                          const Take& take) const {
  const std::optional<Stretch> in = stretch_in_box(ray, box_.low, box_.high);
  if (!in)
    return;
  double near = std::max(0.0, in->from), far = std::min(t_max, in->to);
  if (!(near < far) || !std::isfinite(far))
    return;
  if (takes_part_) { // not farther than a step beyond this process's cells
    const accel::Tree& tree = sampler_.tree();
    const std::optional<Stretch> own = stretch_in_box(ray, tree.bounds_min(), tree.bounds_max());
    if (!own)
      return;
    near = std::max(near, own->from - step_);
    far = std::min(far, own->to + step_);
  }
  thread_local std::vector<Stretch> stays; // kept for the thread's life
  clip_ray(clips_, ray, near, far, stays);
  for (const Stretch& stay : stays) {
    bool goes_on = true;
    if (!majorants_)
      goes_on = follow(ray, stay.from, stay.to, samples, take);
    else
      for_each_macrocell(
          majorants_->grid(), ray, stay.from, stay.to, [&](std::int64_t m, double from, double to) {
            return goes_on = majorants_->opacity(m) <= 0 || follow(ray, from, to, samples, take);
          });
    if (!goes_on)
      break;
  }
}

/// The samples in (from, to].
bool VolumeShadow::follow(const Ray& ray, double from, double to, std::int64_t& samples,
                          const Take& take) const {
  constexpr std::int64_t most = 32;
  math::Vec3d points[most];
  query::Location found[most];
  const auto end = std::int64_t(std::ceil(to / step_ - 0.5));
  for (auto first = std::int64_t(std::ceil(from / step_ - 0.5)); first < end; first += most) {
    const auto count = std::size_t(std::min(most, end - first));
    for (std::size_t i = 0; i < count; ++i)
      points[i] = ray.origin + ((double(first) + double(i) + 0.5) * step_) * ray.direction;
    located_.locate_serial({points, count}, {found, count}, options_);
    samples += std::int64_t(count);
    if (!take(first, {found, count}))
      return false;
  }
  return true;
}

} // namespace insitu::render
