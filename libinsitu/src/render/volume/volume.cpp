#include "render/volume/volume.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "accel/tree/tree.h"
#include "core/count_bits.h"
#include "core/status.h"
#include "render/volume/scalar_values.h"
#include "render/volume/volume_scratch.h"

namespace insitu::render {

using math::Vec3d;

double ray_step(const query::Sampler& sampler, const VolumeSettings& s) {
  const double step = s.step ? *s.step : s.step_factor * typical_cell_size(sampler);
  // Lattice indices must stay far from what a double counts exactly.
  if (!(step > 1e-7 * mesh_diagonal(sampler)) || !std::isfinite(step))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("volume of '") + s.field.field.name + "': a ray step of " +
                          std::to_string(step) +
                          "; more than 1e-7 of the mesh's diagonal expected");
  return step;
}

double unit_distance_of(const query::Sampler& sampler, const VolumeSettings& s) {
  return s.unit_distance > 0 ? s.unit_distance : 0.01 * mesh_diagonal(sampler);
}

void check(const VolumeSettings& s) {
  if (s.field.component >= s.field.field.components)
    throw core::Error(INSITU_ERROR_FIELD, std::string("volume of '") + s.field.field.name +
                                              "': component " + std::to_string(s.field.component) +
                                              " asked for, " +
                                              std::to_string(s.field.field.components) + " held");
  if (s.sample_group < 0 || s.sample_group > query::RayBundleLocator::most_depth)
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("volume of '") + s.field.field.name + "': sample groups of " +
                          std::to_string(s.sample_group) + "; 0 to " +
                          std::to_string(query::RayBundleLocator::most_depth) + " expected");
  if (s.preintegrated && s.tolerance)
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("volume of '") + s.field.field.name +
                          "': pre-integration takes even steps, a tolerance makes them uneven; one "
                          "of them expected");
}

VolumeMarcher::Scratch& VolumeMarcher::scratch() {
  thread_local Scratch s; // some hundred KB, kept for the thread's life
  return s;
}

VolumeMarcher::VolumeMarcher(const query::Sampler& sampler, const VolumeSettings& settings,
                             const VolumeStructures& structures, const Lighting& lighting,
                             bool clipped)
    : sampler_(sampler),
      located_((structures.culled ? sampler.among(*structures.culled) : sampler).among_images()),
      field_(settings.field), function_(settings.function), step_(ray_step(sampler, settings)),
      unit_distance_(unit_distance_of(sampler, settings)), sample_group_(settings.sample_group),
      clipped_(clipped), majorants_(settings.skip_empty ? structures.majorants : nullptr) {
  const mesh::Box outer = outer_bounds(sampler);
  low_ = outer.low;
  high_ = outer.high;
  const mesh::Box ends = sampler.facts().bounds; // trees round their boxes outwards
  inner_low_ = ends.low;
  inner_high_ = ends.high;
  check(settings);
  options_.accuracy = settings.accuracy;
  options_.coordinates = settings.field.field.association != INSITU_CELL;
  if (settings.shading && field_.field.association == INSITU_VERTEX) {
    lighting_ = lighting;
    set_surfaces(nullptr);
  }
  if (settings.tolerance) {
    if (!structures.macrocells)
      throw core::Error(INSITU_ERROR_ARGUMENT, "a volume with a tolerance needs macrocells");
    levels_.emplace(*structures.macrocells, settings.function, step_, unit_distance_,
                    mesh_diagonal(sampler), *settings.tolerance, structures.counted);
    step_ = levels_->base_step();
  }
  for (int level = 0; level < (levels_ ? levels_->count() : 1); ++level)
    classifiers_.emplace_back(settings.function, double(StepLevels::stride(level)) * step_,
                              unit_distance_);
  if (settings.preintegrated && field_.field.association == INSITU_VERTEX)
    preintegration_.emplace(settings.function, step_, unit_distance_, structures.counted);
}

void VolumeMarcher::set_surfaces(const SceneSurfaces* surfaces) {
  if (field_.field.association != INSITU_VERTEX || (!shader_ && surfaces))
    return;
  surfaces_ = surfaces;
  Lighting plain = lighting_;
  plain.shadows = surfaces != nullptr;
  plain.occlusion_samples = 0;
  shader_.emplace(plain, 0.0);
}

void VolumeMarcher::start(RayState& ray) const {
  ray.next = ray.end = 0;
  ray.is_thin = false;
  if (!takes_part_ && located_.tree().empty()) // all of it is culled
    return;
  std::optional<Stretch> in = stretch_in_box(ray.ray, low_, high_);
  if (!in || !(in->to >= 0) || !std::isfinite(in->to) || (clipped_ && ray.stays.empty()))
    return;
  if (const auto inner = stretch_in_box(ray.ray, inner_low_, inner_high_); inner && inner->to >= 0)
    in = inner;
  double near = std::max(0.0, in->from), far = in->to;
  ray.near = near;
  ray.far = far;
  if (clipped_) { // between the stays samples are left out
    near = std::max(near, ray.stays.front().from);
    far = std::min(far, ray.stays.back().to);
  }
  double last = far;
  if (!ray.hits.empty() && ray.hits.back().opacity >= 1) {
    const double behind = preintegration_ ? 1.0 : 0.5; // of the longest step
    far = std::min(far, ray.hits.back().t);
    last = std::min(last, far + behind * longest_step());
  }
  if (!(near <= last))
    return;
  // A sample rounded to the wrong side of the bounds answers for itself.
  const double slack = 1e-9 * (near + last) / step_;
  ray.next = std::max<std::int64_t>(0, std::int64_t(std::ceil(near / step_ - 0.5 - slack)));
  ray.end = std::int64_t(std::floor(last / step_ - 0.5 + slack)) + 1;
  ray.first = ray.next;
  ray.may_skip = majorants_ && majorants_->grid().resolves(ray.ray, last);
  if (ray.next >= ray.end && near < far) { // shorter than a step
    ray.is_thin = true;
    ray.near = near;
    ray.far = far;
  }
}

/// Finds the one sample, in the middle, of rays that pass between two of the lattice.
void VolumeMarcher::locate_thin(std::span<const RayState> rays) const {
  Scratch& s = scratch();
  s.active.clear();
  s.points.clear();
  for (std::size_t r = 0; r < rays.size(); ++r) {
    const RayState& ray = rays[r];
    const double middle = 0.5 * (ray.near + ray.far);
    if (!ray.is_thin || (clipped_ && !stays_at(ray.stays, middle)))
      continue;
    s.active.push_back(std::uint32_t(r));
    s.points.push_back(ray.ray.origin + middle * ray.ray.direction);
  }
  s.found.resize(s.points.size());
  if (!s.active.empty())
    located_.locate_serial(s.points, s.found, options_);
}

std::int64_t VolumeMarcher::march_thin(std::span<RayState> rays) const {
  Scratch& s = scratch();
  locate_thin(rays);
  for (std::size_t a = 0; a < s.active.size(); ++a) {
    RayState& ray = rays[s.active[a]];
    if (s.found[a])
      add_sample(ray, {ray.near, ray.far}, s.found[a], 0);
  }
  return std::int64_t(s.active.size());
}

/// Takes the ray's samples from `first` on, `depth` of the lattice, and says which of them are to
/// be located; sets the ray's next one beyond them.
std::uint32_t VolumeMarcher::advance(RayState& ray, std::int64_t first, int depth,
                                     std::int64_t& skipped) const {
  const std::int64_t stop = std::min(ray.end, first + depth);
  const auto mask = [&](std::int64_t begin, std::int64_t end) {
    begin = std::max(begin, ray.next);
    end = std::min(end, stop);
    if (begin >= end)
      return 0u;
    return std::uint32_t(((std::uint64_t(1) << (end - begin)) - 1) << (begin - first));
  };
  std::uint32_t wanted = 0;
  std::int64_t next = ray.end;
  if (!ray.may_skip) {
    wanted = mask(ray.next, stop);
    next = stop;
  } else {
    // Segments between two samples need both, so one more on either side.
    const std::int64_t wider = preintegration_ ? 1 : 0;
    std::int64_t at = std::max(ray.first, ray.next - wider);
    for_each_macrocell(majorants_->grid(), ray.ray, (double(at) + 0.5) * step_,
                       double(ray.end) * step_, [&](std::int64_t m, double, double to) {
                         const std::int64_t end =
                             std::clamp(std::int64_t(std::ceil(to / step_ - 0.5)), at, ray.end);
                         if (majorants_->opacity(m) > 0) {
                           wanted |= mask(at - wider, end + wider);
                           if (end + wider > stop) {
                             next = std::clamp(at - wider, stop, ray.end);
                             return false;
                           }
                         }
                         at = end;
                         return true;
                       });
  }
  skipped += next - ray.next - core::count_bits(wanted);
  ray.next = next;
  if (clipped_)
    for (std::uint32_t rest = wanted; rest; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      if (!stays_at(ray.stays, (double(first + k) + 0.5) * step_))
        wanted &= ~(std::uint32_t(1) << k);
    }
  return wanted;
}

VolumeCounts VolumeMarcher::march(std::span<RayState> rays, int row) const {
  VolumeCounts counts;
  counts.samples = march_thin(rays);
  constexpr std::size_t most = query::RayBundleLocator::most_rays;
  if (levels_)
    march_levels(rays, counts);
  else
    for (std::size_t first = 0; first < rays.size(); first += most)
      march_bundle(rays.subspan(first, std::min(most, rays.size() - first)), row, counts);
  if (shader_ || preintegration_)
    for (const RayState& ray : rays) {
      counts.lit += ray.lit;
      counts.integrals += ray.integrals;
      counts.shadow_rays += ray.shadow_rays;
    }
  return counts;
}

void VolumeMarcher::march_bundle(std::span<RayState> rays, int row, VolumeCounts& counts) const {
  Scratch& s = scratch();
  s.rays.clear();
  s.active.clear();
  s.last.assign(rays.size(), {});
  for (std::size_t r = 0; r < rays.size(); ++r) {
    s.rays.push_back({rays[r].ray.origin, rays[r].ray.direction});
    if (rays[r].next < rays[r].end)
      s.active.push_back(std::uint32_t(r));
  }
  if (s.active.empty())
    return;
  query::RayBundleLocator locator(located_, options_);
  locator.set_rays(s.rays, row, step_);
  const ScalarValues values(field_, sampler_.mesh());
  const int depth = group();
  while (!s.active.empty()) {
    // All rays over the same stretch, so that their samples share cells; what lies behind the
    // sample that saturates a ray is located in vain.
    std::int64_t first = rays[s.active[0]].next;
    for (const std::uint32_t r : s.active)
      first = std::min(first, rays[r].next);
    first -= first % depth; // the same stretches, whatever is skipped
    s.wanted.assign(rays.size(), 0);
    for (const std::uint32_t r : s.active)
      if (rays[r].next < first + depth) {
        s.wanted[r] = advance(rays[r], first, depth, counts.skipped);
        counts.samples += core::count_bits(s.wanted[r]);
      }
    s.samples.resize(rays.size() * std::size_t(depth));
    s.locations.resize(shader_ ? s.samples.size() : 0);
    locator.locate(first, depth, s.wanted, values, s.samples, s.locations);
    std::size_t kept = 0;
    for (const std::uint32_t r : s.active) {
      RayState& ray = rays[r];
      const std::size_t begin = r * std::size_t(depth);
      gather_stretch(ray, s.last[r], first, s.wanted[r], &s.samples[begin],
                     shader_ ? &s.locations[begin] : nullptr);
      if (ray.next < ray.end && !ray.is_saturated())
        s.active[kept++] = r;
      else
        finish(ray, s.last[r]);
    }
    s.active.resize(kept);
  }
}

} // namespace insitu::render
