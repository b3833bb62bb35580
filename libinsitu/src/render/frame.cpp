#include "render/frame.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>

#include "core/timer.h"
#include "render/path/path_tracer.h"
#include "render/pixel_average.h"
#include "render/surface/surfaces_together.h"
#include "render/volume/volumes_together.h"

namespace insitu::render {

bool has_surfaces(const FrameSettings& settings) {
  return !settings.isosurfaces.empty() || settings.boundary || !settings.bodies.empty() ||
         settings.outline;
}

namespace {

constexpr int tile_side = PathTracer::tile_side, volume_tile_side = 32;

struct Counters {
  std::mutex mutex;
  // Under the mutex:
  SurfaceCounts surfaces;
  VolumeCounts volume;
  PathCounts paths;
  std::int64_t hits = 0, clipped = 0;
};

class FrameRenderer {
public:
  FrameRenderer(std::span<const FrameLayer> layers, const core::Threads& threads)
      : settings_(layers[0].settings), rays_(settings_.camera, settings_.width, settings_.height) {
    // Of several meshes a volume casts its shadow on the surfaces of others too.
    const bool shadows_others =
        settings_.lighting.volume_shadows && std::any_of(layers.begin(), layers.end(), [](auto& l) {
          return has_surfaces(l.settings) && !l.sampler.tree().empty();
        });
    for (const FrameLayer& layer : layers) {
      surfaces_.push_back(nullptr);
      if (!layer.sampler.tree().empty())
        add(layer, shadows_others, threads);
    }
    for (std::size_t l = 0; l < surfaces_.size() && surfaces_.size() > 1; ++l)
      join(l);
    if (!drawn_surfaces_.empty() && settings_.lighting.volume_shadows) {
      const Surfaces* const first = &drawn_surfaces_.front(); // which knows the others
      if (paths_)
        paths_->set_surfaces(first);
      for (VolumeMarcher& volume : marchers_)
        volume.set_surfaces(first);
    }
  }

  /// What is known of the volumes before rays are followed.
  void add_to(FrameStatistics& statistics) const {
    for (const VolumeMarcher* volume : volumes_) {
      statistics.step =
          volume == volumes_[0] ? volume->step() : std::min(statistics.step, volume->step());
      statistics.unheld += volume->unheld();
    }
    for (const query::CulledCells* culled : culled_) {
      statistics.primitives += culled->primitives();
      statistics.culled += culled->culled();
    }
  }

  /// Draws from now on this sample of each pixel of a frame that has several.
  void set_sample(const PixelAverage::Sample& sample) {
    sample_ = std::uint64_t(sample.number);
    if (sample.number > 0)
      rays_ = RayGenerator(settings_.camera, settings_.width, settings_.height).shifted(sample.at);
    if (paths_)
      paths_->set_samples(sample.paths, sample.first_path, settings_.samples_per_pixel,
                          sample.number == 0 && (settings_.depth || settings_.cell));
  }

  /// The side of what draw() takes at once.
  int side() const { return is_tiled() ? IsosurfaceTile::side : part(); }

  void draw(int x0, int y0, FrameImages& images, Counters& counters) const {
    thread_local std::deque<IsosurfaceTile> kept; // these two for the thread's life
    thread_local std::vector<IsosurfaceTile*> tiles;
    tiles.assign(surfaces_.size(), nullptr);
    if (!is_tiled())
      return draw_tile(x0, y0, tiles, images, counters);
    const int x1 = std::min(x0 + IsosurfaceTile::side, settings_.width);
    const int y1 = std::min(y0 + IsosurfaceTile::side, settings_.height);
    SurfaceCounts counts;
    while (kept.size() < surfaces_.size())
      kept.emplace_back();
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
      if (const IsosurfaceTracer* tiled = surfaces_[i] ? surfaces_[i]->tiled() : nullptr) {
        tiles[i] = &kept[i];
        tiles[i]->trace(*tiled, rays_, settings_.clips, x0, y0, x1, y1, counts);
      }
    {
      const std::lock_guard lock(counters.mutex);
      counters.surfaces += counts;
    }
    for (int y = y0; y < y1; y += part())
      for (int x = x0; x < x1; x += part())
        draw_tile(x, y, tiles, images, counters);
  }

private:
  /// Lets rays of light of a layer's surfaces meet those of others.
  void join(std::size_t layer) {
    std::vector<const Surfaces*> others;
    for (const Surfaces& of : drawn_surfaces_)
      if (&of != surfaces_[layer])
        others.push_back(&of);
    for (Surfaces& of : drawn_surfaces_)
      if (&of == surfaces_[layer])
        of.join(std::int32_t(layer), others);
  }

  /// The last of surfaces_ is this layer's.
  void add(const FrameLayer& layer, bool shadows_others, const core::Threads& threads) {
    const auto number = std::int32_t(surfaces_.size()) - 1;
    const auto& [sampler, settings, structures] = layer;
    const query::CulledCells* culled = nullptr;
    if (settings.volume && settings.path_tracing) {
      const VolumeSettings& volume = *settings.volume;
      if (volume.culling == Culling::always)
        culled = structures.culled(volume.field, volume.function);
      const query::Sampler& of = culled ? sampler.among(*culled) : sampler;
      if (!paths_)
        begin_paths();
      paths_->add(of, volume, path_majorants(of, volume, *settings.path_tracing, structures),
                  threads, structures.memory(), number);
    } else if (settings.volume) {
      const VolumeStructures needed = volume_structures(
          sampler, *settings.volume, std::int64_t(settings.width) * settings.height, structures);
      volumes_.push_back(&marchers_.emplace_back(sampler, *settings.volume, needed,
                                                 settings.lighting, !settings.clips.empty()));
      volume_layers_.push_back(number);
      culled = needed.culled;
    }
    if (culled)
      culled_.push_back(culled);
    if (has_surfaces(settings) || (settings.volume && shadows_others))
      surfaces_.back() = &drawn_surfaces_.emplace_back(sampler, settings, structures);
  }

  void begin_paths() {
    PathTracingSettings tracing = *settings_.path_tracing;
    tracing.depth = settings_.depth || settings_.cell;
    if (settings_.samples_per_pixel > 1)
      tracing.sums = nullptr; // the whole samples are added up
    paths_.emplace(tracing, settings_.camera, settings_.lighting.lights, settings_.clips);
  }

  /// The side of what draw_tile() takes; volumes share cells between more rays, and of several
  /// each ray's stretches are kept.
  int part() const { return volumes_.size() == 1 ? volume_tile_side : tile_side; }
  bool is_tiled() const {
    return std::any_of(drawn_surfaces_.begin(), drawn_surfaces_.end(),
                       [](const Surfaces& of) { return of.tiled(); });
  }

  void draw_tile(int x0, int y0, std::span<IsosurfaceTile* const> tiles, FrameImages& images,
                 Counters& counters) const {
    thread_local std::vector<RayState> states;
    const int x1 = std::min(x0 + part(), settings_.width);
    const int y1 = std::min(y0 + part(), settings_.height);
    const std::size_t count = std::size_t(x1 - x0) * std::size_t(y1 - y0);
    if (states.size() < count)
      states.resize(count);
    SurfaceCounts surface_counts;
    std::int64_t hits = 0, clipped = 0;
    std::size_t at = 0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        RayState& state = states[at++];
        state.begin(rays_(x, y));
        state.pixel = pixel_of(x, y);
        state.sample = sample_;
        state.volume_layer = volumes_.size() == 1 ? volume_layers_[0] : 0;
        if (!settings_.clips.empty()) {
          clip_ray(settings_.clips, state.ray, 0, HUGE_VAL, state.stays);
          clipped +=
              state.stays.size() != 1 || state.stays[0].from > 0 || state.stays[0].to < HUGE_VAL;
        }
      }
    const std::span<RayState> rays(states.data(), count);
    if (surfaces_.size() == 1 && surfaces_[0])
      surfaces_[0]->trace(rays, tiles[0], surface_counts);
    else if (!drawn_surfaces_.empty())
      trace_together(surfaces_, rays, tiles, surface_counts);
    for (RayState& state : rays) {
      hits += std::int64_t(state.hits.size());
      if (volumes_.size() == 1)
        volumes_[0]->start(state);
    }
    if (paths_)
      trace_paths(rays, counters);
    VolumeCounts volume_counts;
    if (volumes_.size() == 1)
      volume_counts = volumes_[0]->march(rays, x1 - x0);
    else if (!volumes_.empty())
      volume_counts = march_together(volumes_, volume_layers_, rays, x1 - x0);
    at = 0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        RayState& state = states[at++];
        while (state.next_hit < state.hits.size() && !state.is_saturated())
          state.blend_next_hit();
        if (!images.depth.empty())
          images.depth[pixel_of(x, y)] = float(state.depth);
        if (!images.cell.empty())
          images.cell[pixel_of(x, y)] = state.depth_cell;
        if (!images.layer.empty())
          images.layer[pixel_of(x, y)] = state.depth_layer;
        float* const pixel = images.color.pixel(x, y);
        pixel[0] = state.color.r;
        pixel[1] = state.color.g;
        pixel[2] = state.color.b;
        pixel[3] = state.alpha;
      }
    const std::lock_guard lock(counters.mutex);
    counters.surfaces += surface_counts;
    counters.volume += volume_counts;
    counters.hits += hits;
    counters.clipped += clipped;
  }

  std::size_t pixel_of(int x, int y) const {
    return std::size_t(y) * std::size_t(settings_.width) + std::size_t(x);
  }

  void trace_paths(std::span<RayState> states, Counters& counters) const {
    PathCounts counts;
    paths_->trace(states, counts);
    const std::lock_guard lock(counters.mutex);
    counters.paths += counts;
  }

  const FrameSettings& settings_;
  RayGenerator rays_;
  std::uint64_t sample_ = 0; ///< of each pixel
  std::optional<PathTracer> paths_;
  // By mesh, as far as it has them.
  std::deque<VolumeMarcher> marchers_;
  std::vector<const VolumeMarcher*> volumes_; ///< these
  std::vector<std::int32_t> volume_layers_;   ///< and whose they are
  std::deque<Surfaces> drawn_surfaces_;
  std::vector<const Surfaces*> surfaces_; ///< these by layer; null: it has none
  std::vector<const query::CulledCells*> culled_;
};

/// The image without the background; its color is times alpha.
FrameImages draw_layers(std::span<const FrameLayer> layers, const core::Threads& threads,
                        FrameStatistics* statistics) {
  const FrameSettings& settings = layers[0].settings;
  const core::Timer timer;
  PathSums* const sums = settings.path_tracing ? settings.path_tracing->sums : nullptr;
  if (sums)
    sums->begin(settings.width, settings.height);
  const PixelAverage average(settings);
  FrameRenderer renderer(layers, threads);
  const double prepared = timer.seconds();
  const core::CountedAllocator<float> counted(layers[0].structures.memory(), INSITU_MEMORY_FRAME);
  FrameImages images{
      core::Image(settings.width, settings.height, counted), core::CountedVector<float>(counted),
      core::CountedVector<std::int64_t>(counted), core::CountedVector<std::int32_t>(counted)};
  const std::size_t pixels = std::size_t(settings.width) * std::size_t(settings.height);
  if (settings.depth)
    images.depth.resize(pixels);
  if (settings.cell)
    images.cell.resize(pixels);
  if (settings.cell && layers.size() > 1)
    images.layer.resize(pixels);
  const int side = renderer.side();
  const std::int64_t columns = (settings.width + side - 1) / side;
  const std::int64_t rows = (settings.height + side - 1) / side;
  Counters counters;
  const auto draw = [&](FrameImages& into) {
    threads.parallel_for(columns * rows, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t tile = begin; tile < end; ++tile)
        renderer.draw(int(tile % columns) * side, int(tile / columns) * side, into, counters);
    });
  };
  if (settings.samples_per_pixel == 1) {
    draw(images);
  } else {
    FrameImages one{core::Image(settings.width, settings.height, counted),
                    core::CountedVector<float>(counted), core::CountedVector<std::int64_t>(counted),
                    core::CountedVector<std::int32_t>(counted)};
    for (const PixelAverage::Sample& sample : average.samples()) {
      renderer.set_sample(sample);
      draw(sample.number == 0 ? images : one);
      if (sample.number == 0)
        average.begin(images.color, threads);
      else
        average.add(images.color, one.color, sample, threads);
    }
    average.finish(images.color, threads);
  }
  if (sums)
    sums->end(settings.path_tracing->samples);
  if (statistics) {
    *statistics = {};
    statistics->add(counters.surfaces);
    statistics->add(counters.volume);
    statistics->paths = counters.paths;
    statistics->rays = std::int64_t(pixels) * settings.samples_per_pixel;
    renderer.add_to(*statistics);
    statistics->hits = counters.hits;
    statistics->clipped = counters.clipped;
    statistics->prepare_seconds = prepared;
    statistics->seconds = timer.seconds();
  }
  return images;
}

} // namespace

FrameImages render_frame(const query::Sampler& sampler, const FrameSettings& settings,
                         const core::Threads& threads, core::Memory& memory,
                         FrameStatistics* statistics) {
  Structures structures(memory);
  structures.begin(sampler, 0, 0, threads);
  return render_frame(sampler, settings, structures, threads, statistics);
}

void put_over_background(core::Image& partial, const FrameSettings& settings,
                         const core::Threads& threads) {
  threads.parallel_for(partial.height, tile_side, [&](std::int64_t begin, std::int64_t end) {
    for (int y = int(begin); y < int(end); ++y)
      for (int x = 0; x < partial.width; ++x) {
        float* const pixel = partial.pixel(x, y);
        Color color{pixel[0], pixel[1], pixel[2]};
        float& alpha = pixel[3];
        blend_behind(color, alpha, settings.background, settings.background_alpha);
        const float scale = alpha > 0 ? 1.0f / alpha : 0.0f;
        pixel[0] = scale * color.r;
        pixel[1] = scale * color.g;
        pixel[2] = scale * color.b;
      }
  });
}

FrameImages render_frame(const query::Sampler& sampler, const FrameSettings& settings,
                         Structures& structures, const core::Threads& threads,
                         FrameStatistics* statistics) {
  const FrameLayer layer{sampler, settings, structures};
  return render_frame(std::span(&layer, 1), threads, statistics);
}

FrameImages render_frame(std::span<const FrameLayer> layers, const core::Threads& threads,
                         FrameStatistics* statistics) {
  const core::Timer timer;
  FrameImages images = draw_layers(layers, threads, statistics);
  put_over_background(images.color, layers[0].settings, threads);
  if (statistics)
    statistics->seconds = timer.seconds();
  return images;
}

} // namespace insitu::render
