#include "render/pixel_average.h"

#include <string>

#include "core/status.h"

namespace insitu::render {

namespace {

constexpr std::int64_t numbers_at_once = 1 << 14;

void check(const FrameSettings& settings, bool traces) {
  const int count = settings.samples_per_pixel;
  if (count < 1 || count > PixelAverage::most_samples)
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "frame: 1 to " + std::to_string(PixelAverage::most_samples) +
                          " samples a pixel expected, " + std::to_string(count) + " given");
  if (traces && count > 1 && settings.path_tracing->samples < count)
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "frame: " + std::to_string(count) + " samples a pixel, but only " +
                          std::to_string(settings.path_tracing->samples) + " paths, given");
}

} // namespace

PixelAverage::PixelAverage(const FrameSettings& settings)
    : settings_(settings), traces_(settings.volume && settings.path_tracing) {
  check(settings, traces_);
  const std::int64_t count = settings.samples_per_pixel;
  for (const PixelOffset& at : pixel_samples(int(count))) {
    Sample sample;
    sample.number = int(samples_.size());
    sample.at = at;
    if (traces_) {
      const PathSums* const sums = settings.path_tracing->sums;
      const std::int64_t begin = sums ? sums->samples : 0;
      const std::int64_t end = begin + settings.path_tracing->samples;
      sample.first_path = begin + (sample.number + count - begin % count) % count;
      sample.paths = (end - sample.first_path + count - 1) / count;
    }
    samples_.push_back(sample);
  }
}

void PixelAverage::begin(core::Image& sum, const core::Threads& threads) const {
  const float factor = weight(samples_.front());
  threads.parallel_for(std::int64_t(sum.rgba.size()), numbers_at_once,
                       [&](std::int64_t begin, std::int64_t end) {
                         for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
                           sum.rgba[i] *= factor;
                       });
}

void PixelAverage::add(core::Image& sum, const core::Image& image, const Sample& sample,
                       const core::Threads& threads) const {
  const float factor = weight(sample);
  threads.parallel_for(std::int64_t(sum.rgba.size()), numbers_at_once,
                       [&](std::int64_t begin, std::int64_t end) {
                         for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
                           sum.rgba[i] += factor * image.rgba[i];
                       });
}

void PixelAverage::finish(core::Image& sum, const core::Threads& threads) const {
  PathSums* const sums = traces_ ? settings_.path_tracing->sums : nullptr;
  const std::int64_t here = traces_ ? settings_.path_tracing->samples : settings_.samples_per_pixel;
  const auto all = double(here + (sums ? sums->samples : 0));
  threads.parallel_for(std::int64_t(sum.rgba.size() / 4), numbers_at_once,
                       [&](std::int64_t begin, std::int64_t end) {
                         for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
                           float* const pixel = &sum.rgba[4 * i];
                           PathSums::Pixel whole{double(pixel[0]), double(pixel[1]),
                                                 double(pixel[2]), double(pixel[3])};
                           if (sums) {
                             PathSums::Pixel& kept = sums->pixels[i];
                             whole = {kept.r + whole.r, kept.g + whole.g, kept.b + whole.b,
                                      kept.alpha + whole.alpha};
                             kept = whole;
                           }
                           pixel[0] = float(whole.r / all);
                           pixel[1] = float(whole.g / all);
                           pixel[2] = float(whole.b / all);
                           pixel[3] = float(whole.alpha / all);
                         }
                       });
}

} // namespace insitu::render
