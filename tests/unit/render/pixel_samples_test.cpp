// Several samples a pixel: where they lie, what they average, and what stays that of the centre.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <set>

#include "core/status.h"
#include "render/pixel_average.h"
#include "unit/render/path_frames.h"

namespace insitu::test {
namespace {

using render::FrameImages;
using render::pixel_samples;
using render::PixelOffset;

template <class T>
bool same_bytes(const T& a, const T& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
}

FrameImages images_of(RenderMesh& mesh, const FrameSettings& s, int threads = 0,
                      render::FrameStatistics* statistics = nullptr) {
  return render::render_frame(mesh.sampler(), s, core::Threads(threads), mesh.committed.memory,
                              statistics);
}

/// The box, opaque and bare, seen along x by an orthographic camera, turned a little: its
/// silhouette is a square of 1 x 1, of an image that shows 2 x 2.
FrameSettings silhouette(int size) {
  FrameSettings s;
  s.width = s.height = size;
  s.camera.position = {-2, 0.51, 0.52};
  s.camera.look_at = {0.5, 0.51, 0.52};
  s.camera.up = {0, 0.3, 1};
  s.camera.orthographic_height = 2;
  s.background_alpha = 0;
  s.boundary = {1.0, render::Color{0.5f, 0.25f, 0.125f}};
  s.lighting.enabled = false;
  return s;
}

TEST(PixelSamples, AreOneInEachColumnAndRow) {
  for (const int count : {1, 2, 3, 4, 5, 9, 16, 64, 255, 256}) {
    SCOPED_TRACE(count);
    const std::vector<PixelOffset> samples = pixel_samples(count);
    ASSERT_EQ(samples.size(), std::size_t(count));
    EXPECT_EQ(samples[0], (PixelOffset{0, 0}));
    for (const std::size_t axis : {0, 1}) {
      std::set<std::int64_t> layers;
      double sum = 0;
      for (const PixelOffset& at : samples) {
        EXPECT_TRUE(at[axis] >= -0.5 && at[axis] < 0.5) << at[axis];
        layers.insert(std::llround(at[axis] * count));
        sum += at[axis];
      }
      EXPECT_EQ(layers.size(), std::size_t(count));
      EXPECT_NEAR(sum, count % 2 == 1 ? 0 : -0.5, 1e-9);
    }
  }
}

TEST(PixelSamples, AreWhereShiftedRaysGo) {
  for (const double height : {0.0, 3.0}) {
    render::Camera c;
    c.position = {1, 2, 3};
    c.orthographic_height = height;
    const render::RayGenerator rays(c, 20, 10);
    const render::Ray ray = rays.shifted({0.25, -0.375})(7, 3);
    const math::Vec3d at = ray.origin + 2.0 * ray.direction;
    const auto seen = rays.project(at);
    ASSERT_TRUE(seen);
    EXPECT_NEAR((*seen)[0], 7.5 + 0.25, 1e-9);
    EXPECT_NEAR((*seen)[1], 3.5 - 0.375, 1e-9);
    // In the moved image that is the pixel's centre.
    const auto moved = rays.shifted({0.25, -0.375}).project(at);
    EXPECT_NEAR((*moved)[0], 7.5, 1e-9);
    EXPECT_NEAR((*moved)[1], 3.5, 1e-9);
  }
}

/// The silhouette covers a quarter of the image, and where it covers a pixel in part, so does its
/// alpha; its colour stays what it is, before a background that lets light through.
TEST(PixelSamples, CoverWhatIsCovered) {
  RenderMesh mesh(3);
  double errors[3];
  for (const int i : {0, 1, 2}) {
    FrameSettings s = silhouette(40);
    s.samples_per_pixel = std::array{1, 9, 64}[std::size_t(i)];
    render::FrameStatistics done;
    const core::Image image = images_of(mesh, s, 0, &done).color;
    EXPECT_EQ(done.rays, 40 * 40 * s.samples_per_pixel);
    double covered = 0;
    int partial = 0;
    for (int p = 0; p < 40 * 40; ++p) {
      const float* pixel = image.pixel(p % 40, p / 40);
      covered += double(pixel[3]) / 1600;
      const bool in_part = pixel[3] != 0 && pixel[3] != 1;
      partial += in_part;
      if (pixel[3] > 0) {
        EXPECT_NEAR(pixel[0], 0.5f, in_part ? 1e-6 : 0.0);
        EXPECT_NEAR(pixel[2], 0.125f, in_part ? 1e-6 : 0.0);
      }
    }
    EXPECT_EQ(partial > 0, i > 0);
    errors[i] = std::fabs(covered - 0.25);
  }
  EXPECT_LT(errors[1], 1e-3);
  EXPECT_LT(errors[2], 3e-4);
}

/// Half of white over black is the linear half, which is lighter than the half of what is shown.
TEST(PixelSamples, AreAveragedInLinearLight) {
  RenderMesh mesh(3);
  FrameSettings s = silhouette(40);
  s.boundary->color = render::Color{1, 1, 1};
  s.samples_per_pixel = 9;
  const core::Image alone = images_of(mesh, s).color;
  s.background = {0, 0, 0};
  s.background_alpha = 1;
  const core::Image image = images_of(mesh, s).color;
  for (int p = 0; p < 40 * 40; ++p) {
    EXPECT_EQ(image.pixel(p % 40, p / 40)[3], 1.0f);
    EXPECT_NEAR(image.pixel(p % 40, p / 40)[1], alone.pixel(p % 40, p / 40)[3], 1e-6);
  }
}

TEST(PixelSamples, SameBytesOnAnyNumberOfThreadsAndDepthOfTheCentre) {
  RenderMesh mesh(5, Shape::tetrahedron, 0.2);
  const auto blob = mesh.field("blob", INSITU_VERTEX, blob_of);
  FrameSettings s = blob_frame(blob, 40);
  s.width = 53; // not a multiple of a tile
  s.depth = s.cell = true;
  s.isosurfaces.push_back({blob, {0.6}, 0.75});
  s.outline = render::OutlineSettings{};
  s.lighting.occlusion_samples = 1;
  for (const bool paths : {false, true}) {
    SCOPED_TRACE(paths);
    if (!paths)
      s.path_tracing.reset();
    else
      s.path_tracing.emplace().samples = 2;
    s.samples_per_pixel = 1;
    const FrameImages centre = images_of(mesh, s);
    if (paths)
      s.path_tracing->samples = 7;
    s.samples_per_pixel = paths ? 4 : 5;
    const FrameImages image = images_of(mesh, s, 1);
    EXPECT_FALSE(same_bytes(image.color.rgba, centre.color.rgba));
    if (!paths) {
      EXPECT_TRUE(same_bytes(image.depth, centre.depth));
      EXPECT_TRUE(same_bytes(image.cell, centre.cell));
    }
    for (const int threads : {2, 5}) {
      const FrameImages other = images_of(mesh, s, threads);
      EXPECT_TRUE(same_bytes(image.color.rgba, other.color.rgba)) << threads;
      EXPECT_TRUE(same_bytes(image.depth, other.depth)) << threads;
      EXPECT_TRUE(same_bytes(image.cell, other.cell)) << threads;
    }
  }
}

/// Each sample has random numbers of its own: a place that one ray finds either open or not is
/// open in part to nine.
TEST(PixelSamples, RandomNumbersDiffer) {
  RenderMesh mesh(6);
  FrameSettings s = box_frame(24);
  s.isosurfaces.push_back({mesh.field("x", INSITU_VERTEX, x_of), {0.5}});
  s.boundary = {1.0, render::Color{1, 1, 1}};
  render::Clip cut;
  cut.kind = render::Clip::Kind::box;
  cut.point = {0.5, 0.2, 0.2};
  cut.vector = {2, 2, 2};
  cut.keep_inside = false;
  s.clips = {cut};
  s.lighting.occlusion_samples = 1;
  s.lighting.occlusion_distance = 0.7;
  s.lighting.diffuse = 0;
  std::set<float> values[2];
  for (const int i : {0, 1}) {
    s.samples_per_pixel = i == 0 ? 1 : 9;
    const core::Image image = images_of(mesh, s).color;
    for (std::size_t p = 0; p < 24 * 24; ++p)
      values[i].insert(image.rgba[4 * p]);
  }
  EXPECT_LE(values[0].size(), 5u); // two surfaces, the background
  EXPECT_GE(values[1].size(), 12u);
}

/// Paths are spread over the samples: as many as without, each of the same light in the mean.
TEST(PixelSamples, ShareThePathsOfAPixel) {
  RenderMesh mesh(5, Shape::hexahedron, 0.2);
  const auto x = mesh.field("x", INSITU_VERTEX, x_of);
  const double k = 1.3;
  FrameSettings s = one_ray();
  s.volume = VolumeSettings{x, medium_of({0, 0, 1}, opacity_of(k), opacity_of(k))};
  s.volume->unit_distance = 1;
  s.path_tracing->scattering = render::Scattering::none;
  s.path_tracing->samples = 401;
  s.samples_per_pixel = 5;
  render::PathCounts counts;
  const core::Image image = draw_paths(mesh, s, &counts);
  EXPECT_EQ(counts.paths, 401 * 256);
  expect_mean(estimate(image, 2), 1 - std::exp(-k), "medium");
  s.path_tracing->samples = 4;
  EXPECT_THROW(draw_paths(mesh, s), core::Error);
  s.samples_per_pixel = 257;
  s.path_tracing->samples = 400;
  EXPECT_THROW(draw_paths(mesh, s), core::Error);
}

/// Frames that add up have the paths of one frame of all of them, also where not each sample gets
/// as many in one frame, and where pixels meet the medium by some of their samples.
TEST(PixelSamples, AddUpOverFrames) {
  RenderMesh mesh(6, Shape::hexahedron, 0.2);
  FrameSettings s = blob_frame(mesh.field("blob", INSITU_VERTEX, blob_of), 32);
  s.boundary = {0.3, render::Color{1, 0.5f, 0.25f}};
  s.samples_per_pixel = 3;
  s.path_tracing->samples = 12;
  const core::Image at_once = images_of(mesh, s).color;
  render::PathSums sums(mesh.committed.memory);
  s.path_tracing->sums = &sums;
  core::Image image;
  for (const int samples : {4, 3, 5}) {
    s.path_tracing->samples = samples;
    image = images_of(mesh, s).color;
  }
  EXPECT_EQ(sums.samples, 12);
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
    ASSERT_NEAR(image.rgba[i], at_once.rgba[i], 3e-6 * (1 + std::fabs(at_once.rgba[i])));
}

} // namespace
} // namespace insitu::test
