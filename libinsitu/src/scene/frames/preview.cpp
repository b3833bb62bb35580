#include "scene/frames/preview.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/status.h"

namespace insitu::scene {

namespace {

constexpr std::array<int, 2> preview_size{160, 120};
constexpr int most_preview_paths = 16;

/// Returns the largest size of the same aspect that fits, at least a pixel each way; sizes that fit
/// stay as they are.
std::array<int, 2> fit(const std::array<int, 2>& size) {
  const double factor =
      std::min({1.0, double(preview_size[0]) / size[0], double(preview_size[1]) / size[1]});
  const auto side = [&](int n) { return std::max(1, int(std::lround(factor * n))); };
  return {side(size[0]), side(size[1])};
}

} // namespace

std::string preview_folder(const std::string& output) {
  return (std::filesystem::path(output) / "preview").string();
}

SceneDescription preview_of(SceneDescription scene) {
  if (scene.frames.empty())
    throw core::Error(INSITU_ERROR_SCENE, scene.file + ": the scene has no frame to preview");
  scene.output = preview_folder(scene.output);
  scene.probes.clear();
  scene.tracers.clear();
  scene.checkpoint = {};
  scene.record = {};
  scene.held_steps = 0;
  scene.page = false;
  scene.trigger = {};
  for (Frame& frame : scene.frames) {
    frame.size = fit(frame.size);
    frame.samples_per_pixel = 1;
    if (frame.path_tracing)
      frame.path_tracing->samples = std::min(frame.path_tracing->samples, most_preview_paths);
    frame.trigger = {};
  }
  return scene;
}

} // namespace insitu::scene
