#include "render/path/path_tracer.h"

#include <string>

#include "core/status.h"
#include "render/path/path_grid.h"
#include "render/path/path_wave.h"

namespace insitu::render {

namespace {

const PathTracingSettings& checked(const PathTracingSettings& s) {
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
  return s;
}

} // namespace

const Majorants& path_majorants(const query::Sampler& sampler, const VolumeSettings& volume,
                                const PathTracingSettings& settings, Structures& structures) {
  if (volume.field.component >= volume.field.field.components)
    throw core::Error(INSITU_ERROR_FIELD,
                      std::string("volume of '") + volume.field.field.name + "': component " +
                          std::to_string(volume.field.component) + " asked for, " +
                          std::to_string(volume.field.field.components) + " held");
  if (settings.majorants)
    return *settings.majorants;
  const mesh::MeshFacts facts = sampler.facts();
  const MacrocellGrid grid =
      path_grid(facts, structures.cell_widths(facts.bounds), settings.cells_per_macrocell);
  return structures.majorants(volume.field, volume.function, &grid);
}

PathTracer::PathTracer(const PathTracingSettings& settings, const Camera& camera,
                       const std::vector<Light>& lights, const std::vector<Clip>& clips)
    : settings_(checked(settings)), lights_(lights, camera), clips_(clips) {}

void PathTracer::add(const query::Sampler& sampler, const VolumeSettings& volume,
                     const Majorants& majorants, const core::Threads& threads, core::Memory& memory,
                     std::int32_t layer) {
  media_.emplace_back(sampler, volume, settings_.density, majorants, threads, memory);
  layers_.push_back(layer);
  if (media_.size() == 1)
    bounds_ = media_.back().bounds();
  bounds_.extend(media_.back().bounds());
}

bool PathTracer::clip_to_bounds(const Ray& ray, double& near, double& far) const {
  return clip_to_box(ray, bounds_, near, far);
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
  const bool hints = settings_.locate == PathTracingSettings::Locate::last_cell;
  for (std::uint32_t m = 0; m < media_.size(); ++m) {
    points.clear();
    asking.clear();
    for (Path& path : paths)
      if (path.asks == Path::Asks::value && path.medium == m) {
        points.push_back(path.place());
        asking.push_back(&path);
      }
    if (settings_.locate == PathTracingSettings::Locate::batch) {
      found.resize(points.size());
      media_[m].find_values(points, found);
      for (std::size_t i = 0; i < asking.size(); ++i)
        asking[i]->found = found[i];
      continue;
    }
    for (std::size_t i = 0; i < asking.size(); ++i)
      asking[i]->found = media_[m].value_at(points[i], hints ? asking[i]->found.cell : -1);
  }
}

} // namespace insitu::render
