#include "render/path/path_tracer.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"
#include "render/path/path_grid.h"
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

const Majorants& path_majorants(const query::Sampler& sampler, const VolumeSettings& volume,
                                const PathTracingSettings& settings, Structures& structures) {
  if (settings.majorants)
    return *settings.majorants;
  const mesh::MeshFacts facts = sampler.facts();
  const MacrocellGrid grid =
      path_grid(facts, structures.cell_widths(facts.bounds), settings.cells_per_macrocell);
  return structures.majorants(volume.field, volume.function, &grid);
}

PathTracer::PathTracer(const query::Sampler& sampler, const VolumeSettings& volume,
                       const PathTracingSettings& settings, const Camera& camera,
                       const std::vector<Light>& lights, const std::vector<Clip>& clips,
                       Structures& structures, const core::Threads& threads)
    : settings_(checked(settings, volume)),
      medium_(sampler, volume.field, volume.function, settings.density,
              unit_distance_of(sampler, volume),
              path_majorants(sampler, volume, settings, structures), threads, structures.memory()),
      lights_(lights, camera), clips_(clips), low_(sampler.facts().bounds.low),
      high_(sampler.facts().bounds.high) {
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

void PathTracer::trace(std::span<RayState> rays, PathCounts& counts) const {
  thread_local PathWave wave; // some hundred KB, kept for the thread's life
  wave.begin(*this, rays);
  while (!wave.waiting().empty()) {
    answer(wave.waiting());
    wave.go_on();
  }
  wave.store();
  counts += wave.counts();
}

void PathTracer::answer(std::span<Path> paths) const {
  answer_values(paths);
  for (Path& path : paths)
    if (path.asks == Path::Asks::light)
      path.open = surfaces_->open(path.ray, path.far);
    else if (path.asks == Path::Asks::wall)
      surfaces_->meet(
          path.ray, [&](float opacity) { return path.ends_at(opacity); }, path.seed, path.wall,
          path.wall_color);
}

void PathTracer::answer_values(std::span<Path> paths) const {
  thread_local std::vector<math::Vec3d> points; // these three for the thread's life
  thread_local std::vector<PlaceValue> found;
  thread_local std::vector<Path*> asking;
  points.clear();
  asking.clear();
  for (Path& path : paths)
    if (path.asks == Path::Asks::value) {
      points.push_back(path.place());
      asking.push_back(&path);
    }
  if (settings_.locate == PathTracingSettings::Locate::batch) {
    found.resize(points.size());
    find_values(points, found);
    for (std::size_t i = 0; i < asking.size(); ++i)
      asking[i]->found = found[i];
    return;
  }
  const bool hints = settings_.locate == PathTracingSettings::Locate::last_cell;
  for (std::size_t i = 0; i < asking.size(); ++i)
    asking[i]->found =
        value_at(medium_.sampler().locate(points[i], hints ? asking[i]->found.cell : -1, options_));
}

void PathTracer::find_values(std::span<const math::Vec3d> points,
                             std::span<PlaceValue> found) const {
  thread_local std::vector<query::Location> locations; // kept for the thread's life
  locations.resize(points.size());
  medium_.sampler().locate_serial(points, locations, options_);
  for (std::size_t i = 0; i < points.size(); ++i)
    found[i] = value_at(locations[i]);
}

} // namespace insitu::render
