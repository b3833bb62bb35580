#include "render/path/medium.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/status.h"
#include "render/clip.h"
#include "render/path/path_settings.h"

namespace insitu::render {

Medium::Medium(const query::Sampler& sampler, const VolumeSettings& volume, double density,
               const Majorants& majorants, const core::Threads& threads, core::Memory& memory)
    : sampler_(sampler.among_images()), bounds_(sampler.facts().bounds), field_(volume.field),
      function_(volume.function), grid_(majorants.grid()), majorants_(memory, INSITU_MEMORY_FRAME),
      colors_(function_) {
  options_.accuracy = volume.accuracy;
  options_.coordinates = field_.field.association != INSITU_CELL;
  const double unit_distance = unit_distance_of(sampler, volume);
  scale_ = density / unit_distance;
  if (!(density >= 0) || !(unit_distance > 0) || !std::isfinite(scale_))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("volume of '") + field_.field.name + "': a density of " +
                          std::to_string(density) + " over a unit distance of " +
                          std::to_string(unit_distance) +
                          "; a density of 0 or more and a distance above 0 expected");
  majorants_.resize_discard(std::size_t(grid_.count()));
  threads.parallel_for(grid_.count(), 16384, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const float opacity = majorants.opacity(i);
      // A little above, for the rounding of values and logarithms; exactly 0 where nothing shows.
      majorants_[std::size_t(i)] =
          opacity > 0
              ? std::nextafter(float(extinction_of_opacity(opacity) * (1 + 1e-9)), HUGE_VALF)
              : 0.0f;
    }
  });
}

double Medium::extinction_of_opacity(double opacity) const {
  return scale_ * -std::log1p(-std::min(opacity, largest_opacity));
}

double Medium::extinction(double value) const {
  const double opacity = function_.opacity(value);
  return opacity >= TransferFunction::invisible ? extinction_of_opacity(opacity) : 0.0;
}

Color Medium::albedo(double value) const {
  return std::isnan(value) ? function_.color(value) : colors_(value);
}

bool clip_to_box(const Ray& ray, const mesh::Box& box, double& near, double& far) {
  const std::optional<Stretch> in = stretch_in_box(ray, box.low, box.high);
  if (!in)
    return false;
  near = std::max(near, in->from);
  far = std::min(far, in->to);
  return near < far && std::isfinite(far);
}

void Medium::find_values(std::span<const math::Vec3d> points, std::span<PlaceValue> found) const {
  thread_local std::vector<query::Location> locations; // kept for the thread's life
  locations.resize(points.size());
  sampler_.locate_serial(points, locations, options_);
  for (std::size_t i = 0; i < points.size(); ++i)
    found[i] = value_at(locations[i]);
}

} // namespace insitu::render
