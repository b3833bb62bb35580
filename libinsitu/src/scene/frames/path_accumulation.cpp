#include "scene/frames/path_accumulation.h"

#include <span>

namespace insitu::scene {

void PathAccumulation::use(std::span<const DrawnMesh> meshes, render::FrameSettings& settings,
                           parallel::World& world) {
  if (!settings.path_tracing) {
    return;
  }
  const int right = settings.width - 1, bottom = settings.height - 1;
  const render::RayGenerator rays(settings.camera, settings.width, settings.height);
  const render::Ray a = rays(0, 0), b = rays(right, 0), c = rays(0, bottom);
  State state{{}, {a.origin, a.direction, b.origin, b.direction, c.origin, c.direction}};
  for (const DrawnMesh& drawn : meshes)
    state.meshes.emplace_back(drawn.mesh->id(), drawn.mesh->own_version());
  std::int64_t anew = !(state == state_) || !sums_.is_whole;
  world.reduce(std::span(&anew, 1), parallel::Reduction::greatest);
  if (anew) {
    sums_.restart();
    first_cycle_ = settings.path_tracing->cycle;
  }
  settings.path_tracing->cycle = first_cycle_;
  state_ = std::move(state);
  settings.path_tracing->sums = &sums_;
}

} // namespace insitu::scene
