#include <cmath>
#include <gtest/gtest.h>

#include "render/structures/structures.h"
#include "unit/render/render_mesh.h"

namespace insitu::test {
namespace {

using render::Macrocells;
using render::Majorants;
using render::OpacityPoint;
using render::TransferFunction;

TransferFunction with_opacity(std::vector<OpacityPoint> points) {
  return {render::ColorMap::built_in("viridis"), 0, 1, std::move(points)};
}

double random(std::uint64_t a, std::uint64_t b, std::uint64_t c = 0) {
  return core::random_unit(78, a, b + (c << 32));
}

TEST(TransferFunction, GreatestOpacityOfARange) {
  const std::vector<std::vector<OpacityPoint>> functions = {
      {{0, 0.2}},
      {{0, 0}, {1, 1}},
      {{0.2, 0.1}, {0.4, 0.5}, {0.4, 0.9}, {0.6, 0.3}},                   // a step
      {{0.1, 0}, {0.3, 0}, {0.3, 1}, {0.5, 1}, {0.5, 0}, {0.9, 0}},       // a box
      {{0.1, 0.2}, {0.5, 0.2}, {0.5, 1}, {0.5, 0.2}, {0.9, 0.2}},         // a point never taken
      {{0.3, 0.7}, {0.3, 0.1}, {0.6, 0}, {0.6, 0.4}, {0.6, 0.4}, {1, 0}}, // steps at the ends
  };
  for (std::size_t f = 0; f < functions.size(); ++f) {
    const TransferFunction function = with_opacity(functions[f]);
    for (std::uint64_t i = 0; i < 400; ++i) {
      double low = -0.2 + 1.4 * random(i, 50, f), high = low + 0.7 * random(i, 51, f);
      if (i % 4 == 0) // ends at the points themselves
        low = functions[f][i / 4 % functions[f].size()].value;
      if (i % 4 == 1)
        high = std::max(low, functions[f][i / 4 % functions[f].size()].value);
      high = std::max(low, high);
      double most = std::max(function.opacity(low), function.opacity(high));
      for (int k = 0; k <= 2000; ++k)
        most = std::max(most, function.opacity(low + (high - low) * k / 2000.0));
      for (const OpacityPoint& p : functions[f]) // both sides of steps
        for (const double v : {std::nextafter(p.value, -9.0), p.value})
          if (v >= low && v <= high)
            most = std::max(most, function.opacity(v));
      EXPECT_NEAR(function.max_opacity(low, high), most, 1e-12) << f << " " << low << " " << high;
    }
  }
  EXPECT_EQ(with_opacity({{0, 0}, {1, 1}}).max_opacity(-HUGE_VAL, HUGE_VAL), 1.0);
}

TEST(Majorants, BoundEverySampleAndShowWhatIsEmpty) {
  RenderMesh mesh(12, Shape::wedge, 0.3);
  const auto field = mesh.field("f", INSITU_VERTEX, [](const Vec3d& p) {
    const Vec3d d = p - Vec3d{0.5, 0.5, 0.5};
    return std::max(0.0, 1 - 4 * dot(d, d)); // 0 at the corners
  });
  const query::Sampler sampler = mesh.sampler();
  const Macrocells cells(sampler, field, mesh.committed.threads, mesh.committed.memory, 8);
  const std::vector<std::vector<OpacityPoint>> functions = {
      {{0, 0}, {1, 1}},
      {{0, 0}, {0.7, 0}, {0.7, 0.5}, {1, 0.2}},
      {{0, 0.3}, {0.4, 0}, {1, 0}},
      {{0, 0}},
      {{0, 1e-14}}};
  for (std::size_t f = 0; f < functions.size(); ++f) {
    const TransferFunction function = with_opacity(functions[f]);
    const Majorants majorants(cells, function, mesh.committed.threads, mesh.committed.memory);
    std::int64_t empty = 0;
    for (std::int64_t m = 0; m < cells.grid().count(); ++m) {
      empty += majorants.opacity(m) == 0;
      EXPECT_LE(majorants.opacity(m), 1);
    }
    EXPECT_EQ(majorants.empty_share(), double(empty) / double(cells.grid().count()));
    if (f < 3) {
      EXPECT_GT(empty, 0) << f;
      EXPECT_LT(majorants.empty_share(), 0.95) << f;
    } else {
      EXPECT_EQ(majorants.empty_share(), 1) << f;
    }
    for (std::uint64_t i = 0; i < 20000; ++i) {
      const Vec3d p{random(i, 60), random(i, 61), random(i, 62)};
      const query::Location at = sampler.locate(p);
      ASSERT_TRUE(bool(at));
      const double opacity = function.opacity(field.at(sampler.mesh(), at));
      const double bound = majorants.opacity(majorants.grid().index(p));
      ASSERT_LE(opacity, bound > 0 ? bound : 2 * TransferFunction::invisible) << f << " " << i;
    }
  }
}

TEST(Majorants, OpacityOfNaNCountsWhereThereIsNaN) {
  RenderMesh mesh(8);
  const auto field =
      mesh.field("f", INSITU_CELL, [](const Vec3d& p) { return p.x < 0.3 ? std::nan("") : 0.0; });
  const Macrocells cells(mesh.sampler(), field, mesh.committed.threads, mesh.committed.memory, 8);
  TransferFunction function = with_opacity({{0, 0}, {1, 1}});
  Majorants majorants(cells, function, mesh.committed.threads, mesh.committed.memory);
  EXPECT_EQ(majorants.empty_share(), 1);
  function.set_nan_opacity(0.25);
  majorants.refresh(cells, function, mesh.committed.threads);
  EXPECT_GE(majorants.opacity(majorants.grid().index({0.1, 0.5, 0.5})), 0.25f);
  EXPECT_EQ(majorants.opacity(majorants.grid().index({0.9, 0.5, 0.5})), 0.0f);
}

/// Kept from cycle to cycle, and made anew only for what changed.
TEST(Structures, MacrocellsAndMajorantsFollowWhatChanged) {
  RenderMesh mesh(6);
  auto field = mesh.field("f", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  const core::Threads& threads = mesh.committed.threads;
  render::Structures structures(mesh.committed.memory);
  using Counts = render::Structures::Counts;
  const auto expect = [&](std::int64_t built, std::int64_t refreshed, std::int64_t classified) {
    Counts counts;
    counts.macrocells = built;
    counts.macrocells_refreshed = refreshed;
    counts.majorants = classified;
    EXPECT_EQ(structures.counts(), counts);
  };
  const TransferFunction f = with_opacity({{0, 0}, {1, 1}}), g = with_opacity({{0, 1}, {1, 0}});
  structures.begin(mesh.sampler(), 1, 1, threads);
  const std::int64_t before = mesh.committed.memory.current(INSITU_MEMORY_RANGES);
  structures.majorants(field, f);
  structures.majorants(field, f);
  structures.macrocells(field);
  expect(1, 0, 1);
  const Majorants* of_f = &structures.majorants(field, f);
  EXPECT_NE(&structures.majorants(field, g), of_f); // two frames
  expect(1, 0, 2);
  structures.end();
  // Nothing changed.
  structures.begin(mesh.sampler(), 1, 1, threads);
  structures.majorants(field, g);
  EXPECT_EQ(&structures.majorants(field, f), of_f);
  structures.end();
  expect(1, 0, 2);
  // The function alone: cells are not read, memory is not asked for.
  const std::int64_t held = mesh.committed.memory.current(INSITU_MEMORY_RANGES);
  structures.begin(mesh.sampler(), 1, 1, threads);
  structures.majorants(field, f);
  const Majorants& edited = structures.majorants(field, with_opacity({{0, 0.5}}));
  EXPECT_FLOAT_EQ(edited.opacity(0), 0.5f);
  structures.end();
  expect(1, 0, 3);
  EXPECT_EQ(mesh.committed.memory.current(INSITU_MEMORY_RANGES), held);
  // Other colours are no other opacity.
  structures.begin(mesh.sampler(), 1, 1, threads);
  structures.majorants(field, {render::ColorMap::built_in("inferno"), -3, 4, {{0, 0.5}}});
  structures.end();
  expect(1, 0, 3);
  // New values: in place.
  field = mesh.field("f", INSITU_VERTEX, [](const Vec3d& p) { return 10 + p.x; });
  structures.begin(mesh.sampler(), 1, 2, threads);
  const Majorants& moved = structures.majorants(field, f);
  EXPECT_FLOAT_EQ(moved.opacity(0), 1.0f);
  structures.end();
  expect(1, 1, 4);
  // New geometry: anew.
  structures.begin(mesh.sampler(), 2, 2, threads);
  structures.majorants(field, f);
  structures.end();
  expect(2, 1, 5);
  // Nobody asks: given back.
  structures.begin(mesh.sampler(), 2, 2, threads);
  structures.end();
  EXPECT_EQ(mesh.committed.memory.current(INSITU_MEMORY_RANGES), before);
  expect(2, 1, 5);
}

} // namespace
} // namespace insitu::test
