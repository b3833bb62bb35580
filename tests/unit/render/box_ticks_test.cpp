#include <cmath>
#include <gtest/gtest.h>

#include "output/annotate/box_ticks.h"
#include "unit/render/render_mesh.h"

/// Ticks along a box's outer edges, and their labels.
namespace insitu::test {
namespace {

using output::box_ticks;
using output::BoxTicks;

constexpr int width = 400, height = 300;

/// A camera that sees the box, in perspective or parallel.
render::Camera camera_of(std::uint64_t i, const Vec3d& low, const Vec3d& high) {
  const double azimuth = 360 * core::random_unit(21, i, 0),
               elevation = 180 * core::random_unit(21, i, 1) - 90;
  render::Camera camera =
      render::Camera::around(low, high, azimuth, elevation, 0.8, 60, double(width) / height);
  if (i % 2)
    camera.orthographic_height =
        1.3 * camera.height_for(low, high, render::Fit::sphere, double(width) / height);
  return camera;
}

/// All corners lie on the inner side of an outer edge: that is what makes it one.
TEST(BoxTicks, LieOnOuterEdgesAtTheirValues) {
  const std::pair<Vec3d, Vec3d> boxes[] = {
      {{0, 0, 0}, {1, 1, 1}}, {{-3, 2, 5}, {7, 2.5, 6}}, {{6.4e6, 0, 0}, {6.4e6 + 2, 1, 3}}};
  int axes = 0;
  for (const auto& [low, high] : boxes)
    for (std::uint64_t i = 0; i < 200; ++i) {
      const render::Camera camera = camera_of(i, low, high);
      const render::RayGenerator rays(camera, width, height);
      const BoxTicks ticks = box_ticks(camera, width, height, low, high);
      std::size_t line = 0;
      for (const BoxTicks::Axis& axis : ticks.axes) {
        ++axes;
        ASSERT_GE(axis.values.size(), 2u);
        ASSERT_EQ(axis.values.size(), axis.labels.size());
        ASSERT_EQ(axis.values.size(), axis.ends.size());
        EXPECT_NEAR(std::hypot(axis.outwards[0], axis.outwards[1]), 1, 1e-12);
        for (std::size_t t = 0; t < axis.values.size(); ++t, ++line) {
          const render::OutlineTick& tick = ticks.lines[line];
          EXPECT_EQ(tick.at[axis.axis], axis.values[t]);
          for (const int other : {(axis.axis + 1) % 3, (axis.axis + 2) % 3})
            EXPECT_TRUE(tick.at[other] == low[other] || tick.at[other] == high[other]);
          const auto at = *rays.project(tick.at);
          EXPECT_NEAR(axis.ends[t][0], at[0] + tick.by[0], 1e-9);
          EXPECT_NEAR(axis.ends[t][1], at[1] + tick.by[1], 1e-9);
          for (int corner = 0; corner < 8; ++corner) {
            const Vec3d p{corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                          corner & 4 ? high.z : low.z};
            const auto seen = *rays.project(p);
            // At 6.4e6 a projected corner is rounded to 1e-7 pixels.
            EXPECT_LT((seen[0] - at[0]) * axis.outwards[0] + (seen[1] - at[1]) * axis.outwards[1],
                      1e-5)
                << i;
          }
        }
      }
    }
  EXPECT_GT(axes, 1300); // of 1800; the others are short as they are seen
}

TEST(BoxTicks, FromAboveWithinAndWithoutExtent) {
  render::Camera camera = render::Camera::around({0, 0, 0}, {1, 1, 1}, -90, 90);
  camera.orthographic_height = 1.5; // x to the right, y up
  const BoxTicks above = box_ticks(camera, width, height, {0, 0, 0}, {1, 1, 1});
  ASSERT_EQ(above.axes.size(), 2u);                 // z is seen end on
  EXPECT_NEAR(above.axes[0].outwards[1], 1, 1e-9);  // x below
  EXPECT_NEAR(above.axes[1].outwards[0], -1, 1e-9); // y to the left
  EXPECT_EQ(above.axes[0].values.front(), 0);
  EXPECT_EQ(above.axes[0].values.back(), 1);
  EXPECT_NEAR(above.axes[0].ends.front()[0], width / 2.0 - height / 3.0, 1e-9);
  camera.orthographic_height = 0;
  camera.position = {0.5, 0.5, 0.6};
  camera.look_at = {0.5, 0.6, 2};
  EXPECT_TRUE(box_ticks(camera, width, height, {0, 0, 0}, {1, 1, 1}).axes.empty());
  // A plate of no thickness, and a point.
  const render::Camera aside = render::Camera::around({0, 0, 0}, {1, 1, 0}, 30, 20);
  const BoxTicks plate = box_ticks(aside, width, height, {0, 0, 0}, {1, 1, 0});
  ASSERT_EQ(plate.axes.size(), 2u);
  EXPECT_LT(plate.axes[1].axis, 2);
  EXPECT_TRUE(box_ticks(aside, width, height, {1, 1, 1}, {1, 1, 1}).axes.empty());
}

TEST(BoxTicks, AreLinesThatNearerThingsHide) {
  RenderMesh mesh(2);
  render::FrameSettings s = box_frame(200);
  s.background = {1, 1, 1};
  s.camera.fov = 50;
  s.lighting.enabled = false;
  for (const double parallel : {0.0, 2.4}) {
    s.camera.orthographic_height = parallel;
    s.outline = render::OutlineSettings{{1, 0, 0}, 2, {}};
    s.outline->ticks = box_ticks(s.camera, 200, 200, {0, 0, 0}, {1, 1, 1}).lines;
    ASSERT_GE(s.outline->ticks.size(), 6u);
    s.boundary = render::BoundarySettings{1, render::Color{0, 0, 1}};
    s.bodies.clear();
    const render::RayGenerator rays(s.camera, 200, 200);
    const core::Image shown = mesh.draw(s);
    // A large triangle before all of it.
    const render::CameraAxes axes(s.camera);
    const Vec3d middle = s.camera.position + 0.2 * axes.forward;
    render::TriangleList list;
    list.source = "screen";
    list.corners = {middle - 9.0 * axes.right - 9.0 * axes.down,
                    middle + 9.0 * axes.right - 9.0 * axes.down, middle + 18.0 * axes.down};
    s.bodies.push_back({std::make_shared<render::TriangleList>(list), 1, {0, 1, 0}});
    const core::Image hidden = mesh.draw(s);
    for (const render::OutlineTick& tick : s.outline->ticks) {
      const auto at = *rays.project(tick.at);
      const int x = int(at[0] + 0.7 * tick.by[0]), y = int(at[1] + 0.7 * tick.by[1]);
      EXPECT_LT(shown.pixel(x, y)[1], 0.5f) << x << " " << y;
      EXPECT_GT(shown.pixel(x, y)[0], 0.9f);
      EXPECT_EQ(hidden.pixel(x, y)[1], 1.0f);
      EXPECT_EQ(hidden.pixel(x, y)[0], 0.0f);
    }
  }
}

/// Ink beyond the ticks' ends, and none where there is no room.
TEST(BoxTicks, LabelsStandBeyondTheTicks) {
  for (std::uint64_t i = 0; i < 20; ++i) {
    const render::Camera camera = camera_of(i, {0, 0, 0}, {1, 1, 1});
    const BoxTicks ticks = box_ticks(camera, width, height, {0, 0, 0}, {1, 1, 1});
    core::Image image(width, height);
    output::draw_box_labels(image, ticks);
    int labels = 0, inked = 0;
    for (const BoxTicks::Axis& axis : ticks.axes)
      for (const auto& end : axis.ends) {
        float ink = 0;
        for (int y = -10; y <= 10; ++y)
          for (int x = -10; x <= 10; ++x) {
            const int px = int(end[0] + 12 * axis.outwards[0]) + x,
                      py = int(end[1] + 10 * axis.outwards[1]) + y;
            if (px >= 0 && px < width && py >= 0 && py < height)
              ink += image.pixel(px, py)[3];
          }
        ++labels;
        inked += ink > 8;
      }
    EXPECT_GE(inked, labels - 2) << i; // those at a shared corner are in each other's way
  }
  for (const int side : {1, 8, 30}) {
    core::Image tiny(side, side);
    output::draw_box_labels(
        tiny, box_ticks(camera_of(0, {0, 0, 0}, {1, 1, 1}), side, side, {0, 0, 0}, {1, 1, 1}));
  }
}

} // namespace
} // namespace insitu::test
