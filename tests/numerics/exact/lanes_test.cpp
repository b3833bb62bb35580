/// cells::filter over packs, on every SIMD target, and for scalars: what it proves is so, and it
/// proves nearly all.

#include <gtest/gtest.h>

#include "cases.h"
#include "cells/exact/contain_exact.h"
#include "fixtures/simd_targets.h"
#include "lanes.h"
#include "oracle.h"

namespace insitu::test {
namespace {

using cells::Containment;
using cells::FilterResult;

struct Case {
  Vertices vertices;
  Vec3d point;
};

FilterResult scalar_filter(Shape shape, const Case& c) {
  bool inside = false, outside = false;
  cells::filter(shape, c.vertices.data(), c.point, inside, outside);
  EXPECT_FALSE(inside && outside);
  return inside ? FilterResult::inside : outside ? FilterResult::outside : FilterResult::undecided;
}

struct CellKind {
  const char* name;
  double jitter = 0.0, offset = 0.0;
  Vec3d scale{1, 1, 1};
  double snap = 0.0;
  int merged = 0;
};

constexpr CellKind kinds[] = {
    {.name = "aligned"},
    {.name = "jittered", .jitter = 0.3},
    {.name = "jittered, dyadic", .jitter = 0.3, .snap = 0x1p-6},
    {.name = "coarse, dyadic", .jitter = 0.4, .snap = 0.125},
    {.name = "nearly flat faces", .jitter = 1e-15},
    {.name = "slightly twisted", .jitter = 1e-9, .snap = 0x1p-33},
    {.name = "offset", .jitter = 0.3, .offset = 1e7},
    {.name = "slivers", .jitter = 0.3, .scale = {1, 1, 1e-6}},
    {.name = "needles at an offset", .jitter = 0.3, .offset = 1e7, .scale = {1e6, 1, 1}},
    {.name = "folded", .jitter = 1.5},
    {.name = "folded, dyadic", .jitter = 1.5, .snap = 0.25},
    {.name = "collapsed", .jitter = 0.2, .merged = 2},
    {.name = "collapsed, dyadic", .jitter = 0.2, .snap = 0.125, .merged = 3},
    {.name = "integers", .jitter = 1.5, .snap = 1.0, .merged = 2},
    {.name = "tiny", .jitter = 0.3, .scale = {0x1p-500, 0x1p-400, 0x1p-300}},
    {.name = "huge", .jitter = 0.3, .scale = {0x1p149, 0x1p149, 0x1p300}},
};

Case make_case(Shape shape, const CellKind& kind, Random& random) {
  Case c{unit_cell(shape), {}};
  const int count = mesh::vertex_count(shape), turn = random.below(3), mirror = random.below(8);
  for (int i = 0; i < count; ++i) {
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) {
      double t = c.vertices[i][(axis + turn) % 3];
      if ((mirror >> axis & 1) != 0)
        t = 1 - t;
      t = kind.offset + (t + random.uniform(-kind.jitter, kind.jitter)) * kind.scale[axis];
      p[axis] = kind.snap > 0 ? std::round(t / kind.snap) * kind.snap : t;
    }
    c.vertices[i] = p;
  }
  for (int i = 0; i < kind.merged; ++i)
    c.vertices[random.below(count)] = c.vertices[random.below(count)];
  c.point = adversarial_point(shape, c.vertices.data(), random, kind.snap > 0);
  if (random.below(3) == 0) { // its ray, or the one behind, meets an edge or a diagonal, nearly
    const int i = random.below(count), j = random.below(count);
    const double t = kind.snap > 0 ? random.below(9) / 8.0 : random.uniform(0.0, 1.0);
    c.point = nudge((1 - t) * c.vertices[i] + t * c.vertices[j], random, 1);
    c.point.x += random.uniform(-0.5, 0.5) * kind.scale.x;
  }
  return c;
}

/// Runs cases a block at a time: check(case, result per target).
template <class Make, class Check>
void run_blocks(Shape shape, int blocks, Make&& make, Check&& check) {
  std::vector<Case> cases(LaneBlock::size);
  LaneBlock block;
  FilterResult results[LaneBlock::size];
  for (int b = 0; b < blocks; ++b) {
    block.count = 0;
    for (Case& c : cases) {
      c = make();
      block.add(shape, c.vertices.data(), c.point);
    }
    for (const std::int64_t target : fixtures::simd_targets()) {
      fixtures::use_simd_target(target);
      filter_lanes(shape, block, results);
      for (std::size_t k = 0; k < cases.size(); ++k)
        check(cases[k], results[k], target);
    }
    fixtures::use_simd_target(0);
    if (testing::Test::HasFatalFailure())
      return;
  }
}

void expect_proof(Shape shape, const Case& c, FilterResult result, Containment truth) {
  if (result == FilterResult::undecided)
    return;
  ASSERT_EQ(result == FilterResult::inside ? Containment::inside : Containment::outside, truth)
      << describe(shape, c.vertices.data(), c.point);
}

TEST(ContainLanes, ProveOnlyWhatTheOracleSays) {
  std::uint64_t seed = 500;
  for (const CellKind& kind : kinds) {
    SCOPED_TRACE(std::string(kind.name) + ", seed " + std::to_string(++seed));
    Random random(seed);
    for (Shape shape : all_shapes)
      for (int i = 0; i < 200; ++i) {
        const Case c = make_case(shape, kind, random);
        const Containment truth = oracle_contain(shape, c.vertices.data(), c.point, random.bits());
        expect_proof(shape, c, scalar_filter(shape, c), truth);
        if (HasFatalFailure())
          return;
      }
  }
}

/// More cases than the oracle has time for, against contain_exact, which it vouches for.
TEST(ContainLanes, ProveOnlyWhatIsSoOnEveryTarget) {
  std::uint64_t seed = 600;
  for (const CellKind& kind : kinds) {
    SCOPED_TRACE(std::string(kind.name) + ", seed " + std::to_string(++seed));
    Random random(seed);
    for (Shape shape : all_shapes) {
      run_blocks(
          shape, 16, [&] { return make_case(shape, kind, random); },
          [&](const Case& c, FilterResult result, std::int64_t target) {
            SCOPED_TRACE("target " + std::to_string(target));
            expect_proof(shape, c, result,
                         cells::contain_exact(shape, c.vertices.data(), c.point).where);
            expect_proof(shape, c, scalar_filter(shape, c),
                         cells::contain_exact(shape, c.vertices.data(), c.point).where);
          });
      if (HasFatalFailure())
        return;
    }
  }
}

/// The share of random points in and around a cell that is left undecided: at most 1e-3 is asked
/// for, and distances below 1e-13 of a cell are some 1e-12 of its volume.
TEST(ContainLanes, DecideRandomPoints) {
  Random random(700);
  for (Shape shape : all_shapes)
    for (const double jitter : {0.0, 0.2, 0.4}) {
      int undecided = 0, inside = 0, all = 0;
      run_blocks(
          shape, 60,
          [&] {
            Case c{unit_cell(shape), random.uniform({-0.3, -0.3, -0.3}, {1.3, 1.3, 1.3})};
            for (Vec3d& v : c.vertices)
              v += random.uniform({-jitter, -jitter, -jitter}, {jitter, jitter, jitter});
            return c;
          },
          [&](const Case&, FilterResult result, std::int64_t) {
            undecided += result == FilterResult::undecided;
            inside += result == FilterResult::inside;
            ++all;
          });
      EXPECT_EQ(undecided, 0) << mesh::shape_name(shape) << ", jitter " << jitter;
      EXPECT_GT(inside, all / 100);
      EXPECT_LT(inside, all / 2);
    }
}

TEST(ContainLanes, AreUndecidedWhereANumberIsNotFinite) {
  Random random(701);
  const double bad[] = {std::nan(""), HUGE_VAL, -HUGE_VAL};
  for (Shape shape : all_shapes)
    run_blocks(
        shape, 100,
        [&] {
          Case c = make_case(shape, kinds[random.below(4)], random);
          const int at = random.below(mesh::vertex_count(shape) + 1);
          (at == mesh::vertex_count(shape) ? c.point : c.vertices[at])[random.below(3)] =
              bad[random.below(3)];
          return c;
        },
        [&](const Case& c, FilterResult result, std::int64_t) {
          ASSERT_EQ(result, FilterResult::undecided) << describe(shape, c.vertices.data(), c.point);
          ASSERT_EQ(scalar_filter(shape, c), FilterResult::undecided);
        });
}

} // namespace
} // namespace insitu::test
