#include "render/volume.h"

#include <algorithm>
#include <cmath>

#include "accel/tree.h"
#include "core/status.h"

namespace insitu::render {

namespace {

using math::Vec3d;

double diagonal(const query::Sampler& sampler) {
  if (sampler.tree().empty())
    return 1.0;
  const Vec3d d = sampler.tree().bounds_max() - sampler.tree().bounds_min();
  const double length = std::sqrt(dot(d, d));
  return length > 0 ? length : 1.0;
}

double step_of(const query::Sampler& sampler, const VolumeSettings& s) {
  const double step = s.step ? *s.step : s.step_factor * typical_cell_size(sampler);
  // Lattice indices must stay far from what a double counts exactly.
  if (!(step > 1e-7 * diagonal(sampler)) || !std::isfinite(step))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("volume of '") + s.field.field.name + "': a ray step of " +
                          std::to_string(step) +
                          "; more than 1e-7 of the mesh's diagonal expected");
  if (s.field.component >= s.field.field.components)
    throw core::Error(INSITU_ERROR_FIELD, std::string("volume of '") + s.field.field.name +
                                              "': component " + std::to_string(s.field.component) +
                                              " asked for, " +
                                              std::to_string(s.field.field.components) + " held");
  return step;
}

struct Scratch {
  std::vector<std::uint32_t> active;
  std::vector<Vec3d> points;
  std::vector<query::Location> locations;
};

Scratch& scratch() {
  thread_local Scratch s; // some hundred KB, kept for the thread's life
  return s;
}

} // namespace

double typical_cell_size(const query::Sampler& sampler) {
  const accel::Tree& tree = sampler.tree();
  const double across = diagonal(sampler);
  if (tree.empty())
    return across;
  constexpr std::int64_t most = 4096;
  const std::int64_t count = tree.cell_count(), picked = std::min(count, most);
  std::vector<double> sizes;
  sizes.reserve(std::size_t(picked));
  mesh::CellVertices cell;
  for (std::int64_t i = 0; i < picked; ++i) {
    mesh::gather(sampler.mesh(), std::int64_t(tree.cells()[i * count / picked]), cell);
    Vec3d low = cell.x[0], high = cell.x[0];
    for (int v = 1; v < cell.count; ++v)
      for (int a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], cell.x[v][a]);
        high[a] = std::max(high[a], cell.x[v][a]);
      }
    const Vec3d d = high - low;
    sizes.push_back(std::cbrt(d.x * d.y * d.z));
  }
  const auto middle = sizes.begin() + std::ptrdiff_t(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle > 0 ? std::max(*middle, across / 16384) : across / 256;
}

VolumeMarcher::VolumeMarcher(const query::Sampler& sampler, const VolumeSettings& settings)
    : sampler_(sampler), field_(settings.field), step_(step_of(sampler, settings)),
      classifier_(settings.function, step_,
                  settings.unit_distance > 0 ? settings.unit_distance : 0.01 * diagonal(sampler)),
      low_(sampler.tree().bounds_min()), high_(sampler.tree().bounds_max()) {
  options_.accuracy = settings.accuracy;
}

void VolumeMarcher::start(RayState& ray) const {
  double near = 0, far = HUGE_VAL;
  for (int a = 0; a < 3; ++a) {
    const double o = ray.ray.origin[a], d = ray.ray.direction[a];
    if (d == 0) {
      if (o < low_[a] || o > high_[a])
        far = -1;
      continue;
    }
    const double t0 = (low_[a] - o) / d, t1 = (high_[a] - o) / d;
    near = std::max(near, std::min(t0, t1));
    far = std::min(far, std::max(t0, t1));
  }
  ray.next = ray.end = 0;
  if (!(near <= far) || !std::isfinite(far))
    return;
  if (!ray.hits.empty() && ray.hits.back().opacity >= 1)
    far = std::min(far, ray.hits.back().t + 0.5 * step_);
  // A sample rounded to the wrong side of the bounds answers for itself.
  const double slack = 1e-9 * (near + far) / step_;
  ray.next = std::max<std::int64_t>(0, std::int64_t(std::ceil(near / step_ - 0.5 - slack)));
  ray.end = std::int64_t(std::floor(far / step_ - 0.5 + slack)) + 1;
}

void VolumeMarcher::add_sample(RayState& ray, std::int64_t index, const ColorSample& sample,
                               std::int64_t cell) const {
  // Hits within the sample's stretch part it.
  const double from = double(index) * step_, to = from + step_;
  double used = 0;
  while (ray.next_hit < ray.hits.size() && ray.hits[ray.next_hit].t < to) {
    const double upto = std::clamp((ray.hits[ray.next_hit].t - from) / step_, used, 1.0);
    if (upto > used && sample.alpha > 0)
      ray.blend_stretch(sample.color, Classifier::partial(sample.alpha, upto - used),
                        from + used * step_, from + upto * step_, cell);
    used = upto;
    if (ray.is_saturated())
      return;
    ray.blend_next_hit();
    if (ray.is_saturated())
      return;
  }
  if (sample.alpha > 0)
    ray.blend_stretch(sample.color,
                      used > 0 ? Classifier::partial(sample.alpha, 1 - used) : sample.alpha,
                      from + used * step_, to, cell);
}

std::int64_t VolumeMarcher::march(std::span<RayState> rays) const {
  Scratch& s = scratch();
  s.active.clear();
  for (std::size_t r = 0; r < rays.size(); ++r)
    if (rays[r].next < rays[r].end)
      s.active.push_back(std::uint32_t(r));
  std::int64_t taken = 0;
  while (!s.active.empty()) {
    // A few samples of each ray at a time fill the locator's batches; more of each once few rays
    // are left. How many depends on the rays alone.
    const std::int64_t chunk =
        std::clamp<std::int64_t>(2048 / std::int64_t(s.active.size()), 8, 64);
    // Side by side before front to back: neighbouring rays share more cells than a ray's samples
    // do.
    s.points.clear();
    for (std::int64_t k = 0; k < chunk; ++k)
      for (const std::uint32_t r : s.active) {
        const RayState& ray = rays[r];
        if (ray.next + k < ray.end)
          s.points.push_back(ray.ray.origin +
                             ((double(ray.next + k) + 0.5) * step_) * ray.ray.direction);
      }
    s.locations.resize(s.points.size());
    sampler_.locate_serial(s.points, s.locations, options_);
    taken += std::int64_t(s.points.size());
    const query::Location* location = s.locations.data();
    for (std::int64_t k = 0; k < chunk; ++k)
      for (const std::uint32_t r : s.active) {
        RayState& ray = rays[r];
        if (ray.next + k >= ray.end)
          continue;
        const query::Location& at = *location++;
        if (!ray.is_saturated())
          add_sample(ray, ray.next + k,
                     at ? classifier_(field_.at(sampler_.mesh(), at)) : ColorSample{}, at.cell);
      }
    std::size_t kept = 0;
    for (const std::uint32_t r : s.active) {
      rays[r].next += chunk;
      if (rays[r].next < rays[r].end && !rays[r].is_saturated())
        s.active[kept++] = r;
    }
    s.active.resize(kept);
  }
  return taken;
}

} // namespace insitu::render
