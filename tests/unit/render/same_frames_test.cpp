// The same frame to the byte, whatever locates points and however many threads draw.
#include <gtest/gtest.h>

#include "core/status.h"
#include "unit/query/registered_amr.h"
#include "unit/render/same_frames.h"

namespace insitu::test {
namespace {

class SameFrames : public testing::TestWithParam<Shape> {};

TEST_P(SameFrames, ByEveryLocatorAndNumberOfThreads) {
  RenderMesh mesh(6, GetParam(), 0.2);
  mesh.field("f", INSITU_VERTEX, blob);
  expect_same_by_all(mesh.committed, [&] {
    return ScalarField{mesh.committed.mesh.mesh().field("f"), -1};
  });
}

INSTANTIATE_TEST_SUITE_P(Shapes, SameFrames,
                         testing::Values(Shape::hexahedron, Shape::tetrahedron, Shape::wedge,
                                         Shape::pyramid));

/// A block's cells are implicit, and are those hexahedra.
TEST(SameFrames, OfBlocksAsOfTheirHexahedra) {
  constexpr int n = 6;
  RenderMesh cells(n, Shape::hexahedron, 0.2);
  cells.field("f", INSITU_VERTEX, blob);
  fixtures::Committed block;
  insitu_block b = insitu_block_default();
  b.kind = INSITU_BLOCK_CURVILINEAR;
  for (std::int64_t& count : b.vertices)
    count = n + 1;
  std::vector<double> points, values;
  for (const Vec3d& p : cells.cells.vertices) {
    points.insert(points.end(), {p.x, p.y, p.z});
    values.push_back(blob(p));
  }
  const auto count = std::int64_t(values.size());
  const insitu_array x = insitu_array_of(points.data(), INSITU_FLOAT64, count, 3);
  const insitu_array f = insitu_array_of(values.data(), INSITU_FLOAT64, count, 1);
  block.mesh.mesh().set_points(0, &x, 1);
  block.mesh.mesh().set_block(0, &b);
  block.mesh.mesh().set_field(0, "f", INSITU_VERTEX, &f, 1);
  block.commit();
  FrameSettings frame = box_frame(24);
  frame.depth = frame.cell = true;
  for (const Technique& technique : techniques) {
    SCOPED_TRACE(technique.name);
    const auto settings = [&](const fixtures::Committed& mesh) {
      return technique.ask(frame, {mesh.mesh.mesh().field("f"), -1});
    };
    expect_same(draw(cells.committed, settings(cells.committed), cells.committed.memory, 2),
                draw(block, settings(block), block.memory, 2));
  }
}

/// An adaptive mesh has no locator but its own, by its dual and by its leaves.
TEST(SameFrames, OfAdaptiveMeshesByEveryNumberOfThreads) {
  for (const auto reconstruction : {INSITU_DUAL, INSITU_NEAREST}) {
    RegisteredAmr amr({.seed = 3, .kind = 0, .roots = 3, .levels = 3}, reconstruction,
                      [](const Vec3d& p) { return 0.5 + 0.5 * std::sin(p.x) * std::cos(p.y); });
    const accel::Tree& tree = amr.committed.sampler().tree();
    FrameSettings frame = box_frame(24);
    frame.camera = render::Camera::around(tree.bounds_min(), tree.bounds_max(), 30, 20);
    frame.depth = frame.cell = true;
    for (const Technique& technique : techniques) {
      SCOPED_TRACE(technique.name);
      const FrameSettings s = technique.ask(frame, {amr.committed.mesh.mesh().field("f"), -1});
      const FrameImages one = draw(amr.committed, s, amr.committed.memory, 1);
      for (const int threads : {2, 5})
        expect_same(one, draw(amr.committed, s, amr.committed.memory, threads));
    }
  }
}

/// Nothing but the background, and no error, where no cell can be drawn.
TEST(SameFrames, OfNoCells) {
  const std::uint8_t all_ghosts[27] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
                                       1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  for (const bool ghosts : {false, true}) {
    SCOPED_TRACE(ghosts ? "all of them ghosts" : "no cell at all");
    TestMesh cells = box_cells(3, Shape::hexahedron, 0.0);
    ASSERT_EQ(cells.cells.size(), std::size(all_ghosts));
    if (!ghosts)
      cells.cells.clear();
    RenderMesh mesh(cells);
    mesh.field("f", INSITU_VERTEX, blob);
    if (ghosts) {
      const insitu_array a = insitu_array_of(all_ghosts, INSITU_UINT8, 27, 1);
      mesh.committed.mesh.mesh().set_ghosts(0, &a, INSITU_GHOSTS_VTK);
      mesh.committed.commit();
    }
    ASSERT_TRUE(mesh.sampler().tree().empty());
    FrameSettings frame = box_frame(8);
    frame.background = {0.25f, 0.5f, 0.75f};
    frame.depth = frame.cell = true;
    frame.boundary.emplace();
    frame.outline.emplace();
    for (const Technique& technique : techniques) {
      SCOPED_TRACE(technique.name);
      const FrameSettings s = technique.ask(frame, {mesh.committed.mesh.mesh().field("f"), -1});
      const FrameImages images = draw(mesh.committed, s, mesh.committed.memory, 2);
      for (int i = 0; i < 64; ++i) {
        EXPECT_EQ(images.color.pixel(i % 8, i / 8)[1], 0.5f);
        EXPECT_EQ(images.color.pixel(i % 8, i / 8)[3], 1.0f);
        EXPECT_EQ(images.depth[std::size_t(i)], HUGE_VALF);
        EXPECT_EQ(images.cell[std::size_t(i)], -1);
      }
    }
  }
}

TEST(SameFrames, ImagesWithoutPixelsAreRefused) {
  RenderMesh mesh(2);
  FrameSettings s = box_frame(4);
  for (const auto& [width, height] : {std::pair{0, 4}, {4, 0}, {-1, 4}}) {
    s.width = width;
    s.height = height;
    EXPECT_THROW(mesh.draw(s), core::Error) << width << " x " << height;
  }
}

} // namespace
} // namespace insitu::test
