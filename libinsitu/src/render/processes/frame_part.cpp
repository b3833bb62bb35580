#include "render/processes/frame_part.h"

#include <array>
#include <bit>
#include <optional>
#include <span>

#include "core/status.h"
#include "core/timer.h"
#include "render/processes/shared_frame.h"

namespace insitu::render {

const char* why_exact(const FrameSettings& s) {
  if (!s.volume)
    return nullptr; // surfaces alone are always exact
  if (s.path_tracing)
    return "paths are traced";
  if (s.volume->tolerance)
    return "a tolerance makes steps uneven";
  if (s.depth || s.cell)
    return "images of depth and of cells need each sample";
  if (s.volume->shading && s.lighting.volume_shadows)
    return "shadows on a lit volume need each sample";
  return nullptr;
}

const char* why_exact(std::span<const FrameSettings* const> layers) {
  const char* why = nullptr;
  int volumes = 0;
  for (const FrameSettings* const settings : layers) {
    volumes += settings->volume.has_value();
    why = why ? why : why_exact(*settings);
  }
  return volumes > 1 ? "volumes of several meshes are blended sample by sample" : why;
}

FrameImages render_shared_frame(const FramePart& part, const query::Sampler& sampler,
                                const FrameSettings& settings, Structures& structures,
                                const core::Threads& threads, FrameStatistics* statistics) {
  const FrameLayer layer{sampler, settings, structures};
  return render_shared_frame(std::span(&part, 1), std::span(&layer, 1), threads, statistics);
}

FrameImages render_shared_frame(std::span<const FramePart> parts, std::span<const FrameLayer> asked,
                                const core::Threads& threads, FrameStatistics* statistics) {
  const core::Timer timer;
  const FramePart& part = parts[0];
  std::vector<FrameSettings> all; // with what is found out about the whole meshes
  std::vector<FrameLayer> layers;
  std::vector<std::optional<SharedFrame::Known>> known;
  part.world.agree_after([&] {
    for (std::size_t l = 0; l < asked.size() && asked.size() > 1; ++l)
      if (asked[l].settings.cell && parts[l].solvers_cell)
        throw core::Error(INSITU_ERROR_UNSUPPORTED,
                          "images of cells of several meshes, adaptive ones among them, over "
                          "several processes are not there yet");
    all.reserve(asked.size());
    for (std::size_t l = 0; l < asked.size(); ++l) {
      layers.push_back(
          {asked[l].sampler, all.emplace_back(asked[l].settings), asked[l].structures});
    }
    known.resize(asked.size());
  });
  FrameSettings& settings = all[0];
  PathSums* const sums = settings.path_tracing ? settings.path_tracing->sums : nullptr;
  const bool several = settings.samples_per_pixel > 1, is_root = part.world.is_root();
  const core::CountedAllocator<float> counted(layers[0].structures.memory(), INSITU_MEMORY_FRAME);
  const auto blank = [&] {
    return FrameImages{is_root ? core::Image(settings.width, settings.height, counted)
                               : core::Image(0, 0, counted),
                       core::CountedVector<float>(counted),
                       core::CountedVector<std::int64_t>(counted),
                       core::CountedVector<std::int32_t>(counted)};
  };
  FrameImages images, one;
  std::optional<PixelAverage> average;
  std::optional<SharedFrame> frame;
  for (std::size_t l = 0; l < layers.size(); ++l)
    known[l].emplace(parts[l], layers[l], threads);
  part.world.agree_after([&] {
    for (std::size_t l = 0; l < layers.size(); ++l)
      if (all[l].path_tracing)
        all[l].path_tracing->majorants = known[l]->path_majorants.get();
    if (sums)
      sums->begin(settings.width, settings.height, is_root);
    average.emplace(settings);
    images = blank();
    if (settings.depth)
      images.depth.resize(images.color.rgba.size() / 4);
    if (settings.cell)
      images.cell.resize(images.color.rgba.size() / 4);
    if (settings.cell && layers.size() > 1)
      images.layer.resize(images.color.rgba.size() / 4);
    if (several)
      one = blank();
    frame.emplace(parts, layers, known, threads);
  });
  const double prepared = timer.seconds();
  for (const PixelAverage::Sample& sample : average->samples()) {
    if (several)
      frame->set_sample(sample);
    frame->draw(sample.number == 0 ? images : one);
    if (!several || !is_root)
      continue;
    if (sample.number == 0)
      average->begin(images.color, threads);
    else
      average->add(images.color, one.color, sample, threads);
  }
  if (several && is_root)
    average->finish(images.color, threads);
  if (is_root)
    put_over_background(images.color, settings, threads);
  if (sums)
    sums->end(settings.path_tracing->samples);
  auto paths = std::bit_cast<std::array<std::int64_t, 8>>(frame->path_counts());
  if (settings.path_tracing)
    part.world.reduce(std::span(paths), parallel::Reduction::sum);
  if (statistics) {
    *statistics = {};
    frame->add_to(*statistics);
    statistics->paths = std::bit_cast<PathCounts>(paths);
    statistics->rays = std::int64_t(settings.width) * settings.height * settings.samples_per_pixel;
    statistics->prepare_seconds = prepared;
    statistics->seconds = timer.seconds();
  }
  return images;
}

} // namespace insitu::render
