#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "render/frame.h"

namespace insitu::render {

/// Averages the samples of a frame's pixels, see FrameSettings::samples_per_pixel: whole images,
/// one for each sample, are drawn one after the other and added up.
class PixelAverage {
public:
  /// The settings, and the sums of their paths, must outlive this. Throws core::Error
  /// (INSITU_ERROR_ARGUMENT) for counts of samples out of range.
  explicit PixelAverage(const FrameSettings& settings);

  /// One of the samples of each pixel.
  struct Sample {
    int number = 0;
    PixelOffset at{0, 0};
    /// Of the paths that are traced through it: how many, and the number of the first among all
    /// paths of the pixel, those of earlier frames included. The next ones follow at distances of
    /// the count of samples.
    std::int64_t paths = 0, first_path = 0;
  };
  const std::vector<Sample>& samples() const { return samples_; }

  /// Makes the image of the first sample a sum, to which those of the others are added.
  void begin(core::Image& sum, const core::Threads& threads) const;
  void add(core::Image& sum, const core::Image& image, const Sample& sample,
           const core::Threads& threads) const;
  /// Makes the sum an average, over this frame or, where paths add up over frames, over all of
  /// these.
  void finish(core::Image& sum, const core::Threads& threads) const;

  static constexpr int most_samples = 256;

private:
  float weight(const Sample& sample) const { return traces_ ? float(sample.paths) : 1.0f; }

  const FrameSettings& settings_;
  bool traces_; ///< paths: an image counts as often as paths went into it
  std::vector<Sample> samples_;
};

} // namespace insitu::render
