#include <cmath>
#include <gtest/gtest.h>

#include "core/status.h"
#include "unit/render/render_mesh.h"

namespace insitu::test {
namespace {

using render::FrameSettings;
using render::RayGenerator;
using render::VolumeSettings;

TEST(Volume, ConstantMediumObeysBeerAndLambert) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid}) {
    RenderMesh mesh(5, shape, 0.2);
    const auto field = mesh.field("one", INSITU_VERTEX, [](const Vec3d&) { return 1.0; });
    FrameSettings s = box_frame(48);
    s.background_alpha = 0;
    const double opacity = 0.9; // per unit of length
    s.volume = VolumeSettings{field, constant_function(opacity, 0.5)};
    s.volume->unit_distance = 1;
    const double step = 0.02;
    s.volume->step = step;
    render::FrameStatistics statistics;
    const core::Image image = mesh.draw(s, 0, &statistics);
    EXPECT_EQ(statistics.step, step);
    const RayGenerator rays(s.camera, 48, 48);
    int inside = 0;
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 48; ++x) {
        const auto stretch = box_stretch(rays(x, y));
        const float* p = image.pixel(x, y);
        const double length = std::max(0.0, stretch.second - stretch.first);
        // A float's rounding for each of some 80 samples; the bounds' own, 2^-22.
        EXPECT_NEAR(p[3], 1 - std::pow(1 - opacity, length), 1e-6) << x << ", " << y;
        if (p[3] > 0) {
          EXPECT_NEAR(p[0], 0.5, 1e-5); // straight alpha: the medium's own colour
          ++inside;
        }
      }
    EXPECT_GT(inside, 1000);
  }
}

TEST(Volume, LinearFieldMatchesItsQuadrature) {
  RenderMesh mesh(6, Shape::hexahedron, 0.25);
  const auto f = [](const Vec3d& p) { return (p.x + 2 * p.y + 3 * p.z) / 6; };
  const auto field = mesh.field("linear", INSITU_VERTEX, f);
  FrameSettings s = box_frame(24);
  const render::TransferFunction function(
      render::ColorMap("ramp", render::ColorSpace::linear, {{0, 0, 0, 0}, {1, 1, 0, 0}}), 0, 1,
      {{0, 0.1}, {1, 0.6}});
  s.volume = VolumeSettings{field, function};
  s.volume->unit_distance = 0.5;
  s.volume->step = 0.05;
  const core::Image image = mesh.draw(s);
  const RayGenerator rays(s.camera, 24, 24);
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x) {
      const render::Ray ray = rays(x, y);
      const auto [near, far] = box_stretch(ray);
      double color = 0, through = 1;
      for (int i = 0; i < 200; ++i) {
        const double t = (i + 0.5) * 0.05;
        if (t < near || t > far)
          continue;
        // The first and the last sample reach to the box's faces.
        const double from = t - 0.05 < near ? near : t - 0.025;
        const double to = t + 0.05 > far ? far : t + 0.025;
        const double v = f(ray.origin + t * ray.direction);
        const double alpha = 1 - std::pow(1 - (0.1 + 0.5 * v), (to - from) / 0.5);
        color += through * alpha * v;
        through *= 1 - alpha;
      }
      if (far - near < 0.1)
        continue; // at most one sample
      EXPECT_NEAR(image.pixel(x, y)[0], color, 1e-5) << x << ", " << y;
      EXPECT_EQ(image.pixel(x, y)[1], 0.0f);
    }
}

TEST(Volume, CellFieldIsConstantInEachCell) {
  RenderMesh mesh(2); // 2^3 cells: red in one half, blue in the other
  const auto field =
      mesh.field("half", INSITU_CELL, [](const Vec3d& p) { return p.x < 0.5 ? 0.0 : 1.0; });
  FrameSettings s = box_frame(16);
  s.camera = {{0.3, 0.5, 9}, {0.3, 0.5, 0}, {0, 1, 0}, 30, 1.0};
  const render::TransferFunction function(
      render::ColorMap("two", render::ColorSpace::linear, {{0, 1, 0, 0}, {1, 0, 0, 1}}), 0, 1,
      {{0, 1.0}});
  s.volume = VolumeSettings{field, function};
  const core::Image image = mesh.draw(s);
  for (int x = 0; x < 16; ++x) {
    const double at = 0.3 + (x + 0.5) / 16 - 0.5;
    const float* p = image.pixel(x, 8);
    EXPECT_EQ(p[0], at >= 0 && at < 0.5 ? 1.0f : 0.0f) << x;
    EXPECT_EQ(p[2], at >= 0.5 ? 1.0f : 0.0f) << x;
  }
}

TEST(Volume, OpaqueMediumEndsRaysEarly) {
  RenderMesh mesh(4);
  const auto field = mesh.field("one", INSITU_VERTEX, [](const Vec3d&) { return 1.0; });
  FrameSettings s = box_frame(32);
  s.volume = VolumeSettings{field, constant_function(0.01)};
  s.volume->unit_distance = 1;
  s.volume->step = 0.002;
  render::FrameStatistics thin, dense;
  mesh.draw(s, 1, &thin);
  s.volume->function = constant_function(1.0);
  const core::Image image = mesh.draw(s, 1, &dense);
  EXPECT_EQ(image.pixel(16, 16)[0], 1.0f);
  EXPECT_LT(dense.samples * 5, thin.samples);
}

TEST(Volume, NothingIsDrawnOutsideCells) {
  // A field that is not a number in half of the mesh, and a camera within it.
  RenderMesh mesh(4);
  const auto field = mesh.field("half", INSITU_CELL,
                                [](const Vec3d& p) { return p.x < 0.5 ? std::nan("") : 1.0; });
  FrameSettings s = box_frame(8);
  s.background = {0.25f, 0.5f, 0.75f};
  s.camera.position = {0.4, 0.5, 0.5};
  s.camera.look_at = {0, 0.5, 0.5};
  s.volume = VolumeSettings{field, constant_function(1.0)};
  const core::Image none = mesh.draw(s);
  EXPECT_EQ(none.pixel(4, 4)[1], 0.5f);
  s.camera.look_at = {1, 0.5, 0.5};
  const core::Image all = mesh.draw(s);
  EXPECT_NEAR(all.pixel(4, 4)[1], 1.0f, 1e-6);
}

TEST(Volume, TypicalCellSizeAndStep) {
  RenderMesh mesh(8);
  EXPECT_NEAR(render::typical_cell_size(mesh.sampler()), 0.125, 1e-12);
  const auto field = mesh.field("one", INSITU_VERTEX, [](const Vec3d&) { return 1.0; });
  FrameSettings s = box_frame(8);
  s.volume = VolumeSettings{field, constant_function(0.1)};
  s.volume->step_factor = 2;
  render::FrameStatistics statistics;
  mesh.draw(s, 1, &statistics);
  EXPECT_NEAR(statistics.step, 0.25, 1e-12);
  s.volume->step = 0.0;
  EXPECT_THROW(mesh.draw(s), core::Error);
  s.volume->step.reset();
  s.volume->field.component = 1;
  EXPECT_THROW(mesh.draw(s), core::Error);
}

} // namespace
} // namespace insitu::test
