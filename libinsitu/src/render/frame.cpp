#include "render/frame.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/timer.h"

namespace insitu::render {

namespace {

constexpr int tile_side = 16;

struct Counters {
  std::atomic<std::int64_t> samples{0}, skipped{0}, cells_tested{0}, evaluations{0}, hits{0};
};

class FrameRenderer {
public:
  FrameRenderer(const query::Sampler& sampler, const FrameSettings& settings,
                Structures& structures)
      : settings_(settings), rays_(settings.camera, settings.width, settings.height) {
    if (sampler.tree().empty())
      return;
    if (settings.volume)
      volume_.emplace(sampler, *settings.volume,
                      volume_structures(sampler, *settings.volume,
                                        std::int64_t(settings.width) * settings.height, structures),
                      settings.lighting, !settings.clips.empty());
    if (!settings.isosurfaces.empty())
      surfaces_.emplace(sampler, settings.isosurfaces, settings.lighting, structures);
  }

  double step() const { return volume_ ? volume_->step() : 0.0; }

  void draw_tile(int x0, int y0, core::Image& image, Counters& counters) const {
    thread_local std::vector<RayState> states;
    const int x1 = std::min(x0 + tile_side, settings_.width);
    const int y1 = std::min(y0 + tile_side, settings_.height);
    const std::size_t count = std::size_t(x1 - x0) * std::size_t(y1 - y0);
    if (states.size() < count)
      states.resize(count);
    SurfaceCounts surface_counts;
    std::int64_t hits = 0;
    std::size_t at = 0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        RayState& state = states[at++];
        state.ray = rays_(x, y);
        state.color = {};
        state.alpha = 0;
        state.next = state.end = 0;
        state.hits.clear(); // keeps its memory
        state.next_hit = 0;
        state.stays.clear();
        if (!settings_.clips.empty())
          clip_ray(settings_.clips, state.ray, 0, HUGE_VAL, state.stays);
        if (surfaces_)
          surfaces_->trace(state.ray, state.hits, surface_counts,
                           settings_.clips.empty() ? nullptr : &state.stays);
        hits += std::int64_t(state.hits.size());
        if (volume_)
          volume_->start(state);
      }
    if (volume_) {
      const VolumeCounts counts = volume_->march(std::span(states.data(), count));
      counters.samples += counts.samples;
      counters.skipped += counts.skipped;
    }
    at = 0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        RayState& state = states[at++];
        while (state.next_hit < state.hits.size() && !state.is_saturated())
          state.blend_next_hit();
        finish(state, image.pixel(x, y));
      }
    counters.cells_tested += surface_counts.cells_tested;
    counters.evaluations += surface_counts.evaluations;
    counters.hits += hits;
  }

private:
  /// Over the background, with straight alpha.
  void finish(RayState& state, float* pixel) const {
    state.blend(settings_.background, settings_.background_alpha);
    const float scale = state.alpha > 0 ? 1.0f / state.alpha : 0.0f;
    pixel[0] = scale * state.color.r;
    pixel[1] = scale * state.color.g;
    pixel[2] = scale * state.color.b;
    pixel[3] = state.alpha;
  }

  const FrameSettings& settings_;
  RayGenerator rays_;
  std::optional<VolumeMarcher> volume_;
  std::optional<IsosurfaceTracer> surfaces_;
};

} // namespace

FrameImages render_frame(const query::Sampler& sampler, const FrameSettings& settings,
                         const core::Threads& threads, core::Memory& memory,
                         FrameStatistics* statistics) {
  Structures structures(memory);
  structures.begin(sampler, 0, 0, threads);
  return render_frame(sampler, settings, structures, threads, statistics);
}

FrameImages render_frame(const query::Sampler& sampler, const FrameSettings& settings,
                         Structures& structures, const core::Threads& threads,
                         FrameStatistics* statistics) {
  const core::Timer timer;
  const FrameRenderer renderer(sampler, settings, structures);
  const double prepared = timer.seconds();
  FrameImages images;
  images.color = core::Image(settings.width, settings.height);
  core::Image& image = images.color;
  const std::int64_t columns = (settings.width + tile_side - 1) / tile_side;
  const std::int64_t rows = (settings.height + tile_side - 1) / tile_side;
  Counters counters;
  threads.parallel_for(columns * rows, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t tile = begin; tile < end; ++tile)
      renderer.draw_tile(int(tile % columns) * tile_side, int(tile / columns) * tile_side, image,
                         counters);
  });
  if (statistics) {
    statistics->rays = std::int64_t(settings.width) * settings.height;
    statistics->samples = counters.samples;
    statistics->skipped = counters.skipped;
    statistics->step = renderer.step();
    statistics->cells_tested = counters.cells_tested;
    statistics->evaluations = counters.evaluations;
    statistics->hits = counters.hits;
    statistics->prepare_seconds = prepared;
    statistics->seconds = timer.seconds();
  }
  return images;
}

} // namespace insitu::render
