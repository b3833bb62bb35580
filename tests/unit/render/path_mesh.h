#pragma once

#include <cmath>
#include <gtest/gtest.h>

#include "unit/render/render_mesh.h"

/// Path traced frames of which the mean and its error are known.
namespace insitu::test {

/// So many standard errors from the truth fail: by chance one comparison in 150 000, and the seeds
/// are fixed.
constexpr double most_errors = 4.5;

struct Estimate {
  double mean = 0, error = 0; ///< standard error of the mean
};

/// Of one channel (times alpha; 3: alpha) over an image whose pixels all estimate the same.
inline Estimate estimate(const core::Image& image, int channel) {
  double sum = 0, squares = 0;
  const double n = double(image.width) * image.height;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const float* p = image.pixel(x, y);
      const double v = channel == 3 ? double(p[3]) : double(p[channel]) * double(p[3]);
      sum += v;
      squares += v * v;
    }
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1))};
}

/// 1e-6 for the rounding of pixels to float.
inline void expect_mean(const Estimate& e, double truth, const char* what) {
  EXPECT_LT(std::fabs(e.mean - truth), most_errors * e.error + 1e-6)
      << what << ": " << e.mean << " +- " << e.error << ", " << truth << " expected";
}

/// Many pixels of one and the same ray along +x through the unit box, nothing behind.
inline render::FrameSettings one_ray(int side = 16) {
  render::FrameSettings s;
  s.width = s.height = side;
  s.camera.position = {-1, 0.45, 0.55};
  s.camera.look_at = {0, 0.45, 0.55};
  s.camera.up = {0, 0, 1};
  s.camera.orthographic_height = 1e-9;
  s.background_alpha = 0;
  s.lighting.enabled = false;
  s.path_tracing.emplace();
  return s;
}

/// One colour (linear), and opacity linear from `first` at 0 to `last` at 1.
inline render::TransferFunction medium_of(const render::Color& c, double first, double last) {
  const auto stored = [](float v) { return render::srgb_of_linear(double(v)); };
  return {render::ColorMap("one", render::ColorSpace::linear,
                           {{0, stored(c.r), stored(c.g), stored(c.b)}}),
          0.0,
          1.0,
          {{0.0, first}, {1.0, last}}};
}

/// The opacity over unit distance 1 of an extinction.
inline double opacity_of(double extinction) {
  return -std::expm1(-extinction);
}

/// Draws, and checks what always holds.
inline core::Image draw_paths(RenderMesh& mesh, const render::FrameSettings& s,
                              render::PathCounts* counts = nullptr, int threads = 0) {
  render::FrameStatistics statistics;
  const core::Image image = mesh.draw(s, threads, &statistics);
  EXPECT_EQ(statistics.paths.violations, 0);
  EXPECT_EQ(statistics.samples, 0); // nothing was marched
  if (counts)
    *counts = statistics.paths;
  return image;
}

} // namespace insitu::test
