#include "render/path/path_tracer.h"

#include <algorithm>
#include <cmath>

#include "accel/tree/tree.h"
#include "core/status.h"
#include "render/path/path_wave.h"

namespace insitu::render {

namespace {

const PathTracingSettings& checked(const PathTracingSettings& s, const VolumeSettings& volume) {
  const auto refuse = [](const std::string& message) {
    throw core::Error(INSITU_ERROR_ARGUMENT, "path tracing: " + message + " given");
  };
  if (s.samples < 1)
    refuse("1 sample a pixel or more expected, " + std::to_string(s.samples));
  if (!(s.anisotropy > -1 && s.anisotropy < 1))
    refuse("an anisotropy between -1 and 1 expected, " + std::to_string(s.anisotropy));
  if (s.max_bounces < 1)
    refuse("1 bounce or more expected, " + std::to_string(s.max_bounces));
  if (!(s.roulette >= 0 && s.roulette <= 1))
    refuse("a threshold of roulette from 0 to 1 expected, " + std::to_string(s.roulette));
  if (volume.field.component >= volume.field.field.components)
    throw core::Error(INSITU_ERROR_FIELD,
                      std::string("volume of '") + volume.field.field.name + "': component " +
                          std::to_string(volume.field.component) + " asked for, " +
                          std::to_string(volume.field.field.components) + " held");
  return s;
}

} // namespace

PathTracer::PathTracer(const query::Sampler& sampler, const VolumeSettings& volume,
                       const PathTracingSettings& settings, const Camera& camera,
                       const std::vector<Light>& lights, const std::vector<Clip>& clips,
                       Structures& structures, const core::Threads& threads)
    : settings_(checked(settings, volume)),
      culled_(volume.culling == Culling::always ? structures.culled(volume.field, volume.function)
                                                : nullptr),
      medium_(culled_ ? sampler.among(*culled_) : sampler, volume.field, volume.function,
              settings.density, unit_distance_of(sampler, volume),
              structures.majorants(volume.field, volume.function, fineness_of(settings)), threads,
              structures.memory()),
      lights_(lights, camera), clips_(clips), low_(sampler.tree().bounds_min()),
      high_(sampler.tree().bounds_max()) {
  options_.accuracy = volume.accuracy;
  options_.coordinates = volume.field.field.association != INSITU_CELL;
}

bool PathTracer::clip_to_bounds(const Ray& ray, double& near, double& far) const {
  const std::optional<Stretch> in = stretch_in_box(ray, low_, high_);
  if (!in)
    return false;
  near = std::max(near, in->from);
  far = std::min(far, in->to);
  return near < far && std::isfinite(far);
}

void PathTracer::trace(std::span<RayState> rays, std::span<const std::int64_t> pixels,
                       PathCounts& counts) const {
  PathWave(*this, rays, pixels, counts).run();
}

} // namespace insitu::render
