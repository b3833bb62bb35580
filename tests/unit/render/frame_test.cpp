#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "unit/render/render_mesh.h"

namespace insitu::test {
namespace {

using render::Color;
using render::FrameSettings;
using render::IsosurfaceSettings;
using render::VolumeSettings;

double x_of(const Vec3d& p) {
  return p.x;
}

/// One pixel's ray along +x through the middle of the box.
FrameSettings along_x() {
  FrameSettings s;
  s.width = s.height = 1;
  s.camera.position = {-1, 0.45, 0.55};
  s.camera.look_at = {0, 0.45, 0.55};
  s.camera.up = {0, 0, 1};
  s.background = {0, 0, 0};
  s.lighting.enabled = false;
  return s;
}

TEST(Frame, SameBytesForAnyNumberOfThreads) {
  RenderMesh mesh(10, Shape::tetrahedron, 0.2);
  const auto radius = mesh.field("r", INSITU_VERTEX, [](const Vec3d& p) {
    return dot(p - Vec3d{0.5, 0.5, 0.5}, p - Vec3d{0.5, 0.5, 0.5});
  });
  const auto cell = mesh.field("c", INSITU_CELL, x_of);
  FrameSettings s = box_frame();
  s.width = 75; // neither a multiple of a tile
  s.height = 50;
  s.volume =
      VolumeSettings{cell, {render::ColorMap::built_in("viridis"), 0, 1, {{0, 0.1}, {1, 0.3}}}};
  s.volume->unit_distance = 0.1;
  s.isosurfaces.push_back({radius, {0.05, 0.1}, 0.5});
  s.isosurfaces.push_back({cell, {0.3}, 1, render::ColorByField{radius, constant_function(1)}});
  const core::Image one = mesh.draw(s, 1);
  for (const int threads : {2, 4}) {
    const core::Image many = mesh.draw(s, threads);
    ASSERT_EQ(one.rgba.size(), many.rgba.size());
    EXPECT_EQ(std::memcmp(one.rgba.data(), many.rgba.data(), one.rgba.size() * sizeof(float)), 0);
  }
  // And it is a picture of something.
  double least = 9, most = 0;
  for (int y = 0; y < s.height; ++y)
    for (int x = 0; x < s.width; ++x) {
      least = std::min(least, double(one.pixel(x, y)[1]));
      most = std::max(most, double(one.pixel(x, y)[1]));
    }
  EXPECT_EQ(least, 0.0);
  EXPECT_GT(most, 0.3);
}

TEST(Frame, TransparentSurfacesLieInDepthOrder) {
  RenderMesh mesh(4, Shape::hexahedron, 0.2);
  const auto field = mesh.field("x", INSITU_VERTEX, x_of);
  FrameSettings s = along_x();
  // Given in an order that is not theirs in depth.
  s.isosurfaces.push_back({field, {0.8}, 1, Color{0, 0, 1}});
  s.isosurfaces.push_back({field, {0.2}, 0.25, Color{1, 0, 0}});
  s.isosurfaces.push_back({field, {0.6}, 0.5, Color{0, 1, 0}});
  s.isosurfaces.push_back({field, {0.9}, 0.5, Color{1, 1, 1}}); // hidden
  const core::Image front = mesh.draw(s);
  EXPECT_NEAR(front.pixel(0, 0)[0], 0.25, 1e-6);
  EXPECT_NEAR(front.pixel(0, 0)[1], 0.75 * 0.5, 1e-6);
  EXPECT_NEAR(front.pixel(0, 0)[2], 0.75 * 0.5, 1e-6);
  s.camera.position = {2, 0.45, 0.55};
  const core::Image back = mesh.draw(s);
  EXPECT_NEAR(back.pixel(0, 0)[0], 0.5, 1e-6);
  EXPECT_NEAR(back.pixel(0, 0)[2], 0.5 + 0.5, 1e-6); // white's share and the opaque blue's
}

TEST(Frame, SurfaceWithinAMediumPartsItExactly) {
  RenderMesh mesh(4, Shape::hexahedron, 0.2);
  const auto field = mesh.field("x", INSITU_VERTEX, x_of);
  FrameSettings s = along_x();
  s.volume = VolumeSettings{field, constant_function(0.75, 1.0)}; // white
  s.volume->unit_distance = 1;
  s.volume->step = 0.25; // 4 samples in the box; surfaces within the second and the fourth
  s.isosurfaces.push_back({field, {0.4}, 0.5, Color{1, 0, 0}});
  s.isosurfaces.push_back({field, {0.85}, 1, Color{0, 0, 1}});
  const core::Image image = mesh.draw(s);
  const auto through = [](double length) { return std::pow(0.25, length); };
  const double first = through(0.4), second = first * 0.5 * through(0.45);
  const double red = (1 - first) + first * 0.5 + first * 0.5 * (1 - through(0.45));
  const double green = (1 - first) + first * 0.5 * (1 - through(0.45));
  EXPECT_NEAR(image.pixel(0, 0)[0], red, 1e-5);
  EXPECT_NEAR(image.pixel(0, 0)[1], green, 1e-5);
  EXPECT_NEAR(image.pixel(0, 0)[2], green + second, 1e-5);
}

TEST(Frame, HeadlightLightsBothSidesByTheCellsGradient) {
  RenderMesh mesh(3, Shape::wedge, 0.2);
  const double angle = 0.6;
  for (const double sign : {1.0, -1.0}) {
    const auto field = mesh.field(sign > 0 ? "a" : "b", INSITU_VERTEX, [&](const Vec3d& p) {
      return sign * (std::cos(angle) * (p.x - 0.5) + std::sin(angle) * (p.y - 0.5));
    });
    FrameSettings s = along_x();
    s.lighting.enabled = true;
    s.isosurfaces.push_back({field, {0.0}, 1, Color{0.5f, 0.25f, 1.0f}});
    const core::Image image = mesh.draw(s);
    const double shade = s.lighting.ambient + s.lighting.diffuse * std::cos(angle);
    EXPECT_NEAR(image.pixel(0, 0)[0], 0.5 * shade, 1e-6);
    EXPECT_NEAR(image.pixel(0, 0)[2], 1.0 * shade, 1e-6);
  }
}

TEST(Frame, SurfaceIsColouredByAnotherField) {
  RenderMesh mesh(4);
  const auto x = mesh.field("x", INSITU_VERTEX, x_of);
  const auto y = mesh.field("y", INSITU_VERTEX, [](const Vec3d& p) { return p.y; });
  FrameSettings s = along_x();
  const render::TransferFunction ramp(
      render::ColorMap("ramp", render::ColorSpace::linear, {{0, 0, 0, 0}, {1, 1, 1, 1}}), 0, 1);
  s.isosurfaces.push_back({x, {0.5}, 1, render::ColorByField{y, ramp}});
  EXPECT_NEAR(mesh.draw(s).pixel(0, 0)[0], 0.45, 1e-6);
}

TEST(Frame, BackgroundKeepsItsAlpha) {
  RenderMesh mesh(2);
  const auto x = mesh.field("x", INSITU_VERTEX, x_of);
  FrameSettings s = along_x();
  s.background = {0.5f, 0.25f, 0.125f};
  s.background_alpha = 0.5f;
  s.isosurfaces.push_back({x, {7.0}, 1}); // nowhere
  render::FrameStatistics statistics;
  const core::Image image = mesh.draw(s, 1, &statistics);
  EXPECT_FLOAT_EQ(image.pixel(0, 0)[0], 0.5f);
  EXPECT_FLOAT_EQ(image.pixel(0, 0)[3], 0.5f);
  EXPECT_EQ(statistics.cells_tested, 0); // value ranges prune the root
  EXPECT_EQ(statistics.samples, 0);
  EXPECT_EQ(statistics.rays, 1);
}

TEST(Frame, MakesNothingThatIsNotAskedFor) {
  RenderMesh mesh(6);
  const auto x = mesh.field("x", INSITU_VERTEX, x_of);
  core::Memory& memory = mesh.committed.memory;
  FrameSettings s = box_frame(16);
  s.volume = VolumeSettings{x, constant_function(0.5)};
  memory.reset_peak();
  const std::int64_t before = memory.current();
  constexpr std::int64_t image = 16 * 16 * 4 * sizeof(float);
  mesh.draw(s);
  EXPECT_EQ(memory.peak(), before + image); // no value ranges for a volume
  EXPECT_EQ(memory.current(), before);
  s.depth = s.cell = true;
  mesh.draw(s);
  EXPECT_EQ(memory.peak(), before + image + std::int64_t(16 * 16 * (sizeof(float) + 8)));
  s.depth = s.cell = false;
  memory.reset_peak();
  s.isosurfaces.push_back({x, {0.5}, 1});
  mesh.draw(s);
  EXPECT_GT(memory.peak(), before + image);
  EXPECT_EQ(memory.current(), before);
  // Structures that the caller keeps are not made again.
  render::Structures kept(memory);
  kept.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
  render::render_frame(mesh.sampler(), s, kept, mesh.committed.threads);
  EXPECT_EQ(kept.counts(), (render::Structures::Counts{.value_ranges = 1}));
  kept.end();
  memory.reset_peak();
  const std::int64_t with_kept = memory.current();
  kept.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
  render::render_frame(mesh.sampler(), s, kept, mesh.committed.threads);
  EXPECT_EQ(memory.peak(), with_kept + image);
  kept.end();
  // Nor for new values; a cycle without surfaces gives them back.
  kept.begin(mesh.sampler(), 0, 1, mesh.committed.threads);
  render::render_frame(mesh.sampler(), s, kept, mesh.committed.threads);
  EXPECT_EQ(memory.peak(), with_kept + image);
  EXPECT_EQ(kept.counts(),
            (render::Structures::Counts{.value_ranges = 1, .value_ranges_refreshed = 1}));
  kept.end();
  s.isosurfaces.clear();
  kept.begin(mesh.sampler(), 0, 1, mesh.committed.threads);
  render::render_frame(mesh.sampler(), s, kept, mesh.committed.threads);
  kept.end();
  EXPECT_EQ(memory.current(), before);
}

} // namespace
} // namespace insitu::test
