/// contain_exact and contain_filter against the oracle, on cells from tame to broken.

#include <gtest/gtest.h>
#include <map>

#include "cases.h"
#include "cells/exact/contain_exact.h"
#include "cells/kernels/contain_filter.h"
#include "oracle.h"

namespace insitu::test {
namespace {

using cells::Containment;
using cells::FilterResult;

struct CellOptions {
  double jitter = 0.0;
  double offset = 0.0;
  Vec3d scale{1, 1, 1};
  double snap = 0.0;    // coordinates are multiples of it, if not 0
  int merged = 0;       // vertices moved onto others
  bool integer = false; // every coordinate a random integer in 0..3: anything goes
};

Vertices make_cell(Shape shape, const CellOptions& options, Random& random) {
  Vertices v = unit_cell(shape);
  const int count = mesh::vertex_count(shape);
  // A random rotation (axes only) and reflection, so that no coordinate is special.
  const int turn = random.below(3), mirror = random.below(8);
  for (int i = 0; i < count; ++i) {
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) {
      double t = v[i][(axis + turn) % 3];
      if ((mirror >> axis & 1) != 0)
        t = 1 - t;
      t += random.uniform(-options.jitter, options.jitter);
      if (options.integer)
        t = random.below(4);
      t = options.offset + t * options.scale[axis];
      p[axis] = options.snap > 0 ? std::round(t / options.snap) * options.snap : t;
    }
    v[i] = p;
  }
  for (int i = 0; i < options.merged; ++i)
    v[random.below(count)] = v[random.below(count)];
  return v;
}

template <class T>
FilterResult filter(Shape shape, const math::Vec3<T>* v, const math::Vec3<T>& p) {
  switch (shape) {
  case Shape::tetrahedron:
    return cells::contain_filter<Shape::tetrahedron>(v, p);
  case Shape::voxel:
    return cells::contain_filter<Shape::voxel>(v, p);
  case Shape::hexahedron:
    return cells::contain_filter<Shape::hexahedron>(v, p);
  case Shape::wedge:
    return cells::contain_filter<Shape::wedge>(v, p);
  case Shape::pyramid:
    return cells::contain_filter<Shape::pyramid>(v, p);
  case Shape::none:
    break;
  }
  return FilterResult::undecided;
}

/// The filter in float is right about the cell and the point as float has them.
void check_float(Shape shape, const Vertices& v, const Vec3d& p,
                 std::map<FilterResult, int>& seen) {
  std::array<math::Vec3f, 8> vf;
  Vertices vd;
  const auto narrow = [](const Vec3d& a) {
    return math::Vec3f{float(a.x), float(a.y), float(a.z)};
  };
  const auto widen = [](const math::Vec3f& a) { return Vec3d{a.x, a.y, a.z}; };
  for (int i = 0; i < 8; ++i)
    vf[i] = narrow(v[i]), vd[i] = widen(vf[i]);
  const math::Vec3f pf = narrow(p);
  const FilterResult result = filter(shape, vf.data(), pf);
  ++seen[result];
  if (result == FilterResult::undecided)
    return;
  const Containment exact = cells::contain_exact(shape, vd.data(), widen(pf)).where;
  ASSERT_EQ(result == FilterResult::inside ? Containment::inside : Containment::outside, exact)
      << "float filter, " << describe(shape, vd.data(), widen(pf));
}

void compare(const CellOptions& options, std::uint64_t seed, int cells_per_shape,
             int points_per_cell) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  std::map<Containment, int> seen;
  std::map<FilterResult, int> seen_float;
  for (Shape shape : all_shapes) {
    for (int i = 0; i < cells_per_shape; ++i) {
      const Vertices v = make_cell(shape, options, random);
      for (int k = 0; k < points_per_cell; ++k) {
        const Vec3d p =
            adversarial_point(shape, v.data(), random, options.snap > 0 || options.integer);
        const auto answer = cells::contain_exact(shape, v.data(), p);
        const Containment expected = oracle_contain(shape, v.data(), p, random.bits());
        ASSERT_EQ(answer.where, expected) << describe(shape, v.data(), p);
        const FilterResult filtered = filter(shape, v.data(), p);
        if (filtered != FilterResult::undecided) {
          ASSERT_EQ(filtered == FilterResult::inside, expected == Containment::inside)
              << describe(shape, v.data(), p);
          ASSERT_FALSE(answer.exact_used);
        }
        ++seen[expected];
        check_float(shape, v, p, seen_float);
        if (testing::Test::HasFatalFailure())
          return;
      }
    }
  }
  // The cases are what they are meant to be.
  EXPECT_GT(seen[Containment::inside], 0);
  EXPECT_GT(seen[Containment::outside], 0);
  EXPECT_GT(seen[Containment::on_vertex], 0);
  if (options.snap > 0 || options.integer) {
    EXPECT_GT(seen[Containment::on_face], cells_per_shape / 2);
    EXPECT_GT(seen[Containment::on_edge], cells_per_shape / 2);
  }
  if (options.offset == 0.0) {
    EXPECT_GT(seen_float[FilterResult::inside] + seen_float[FilterResult::outside], 0);
  }
}

TEST(ContainOracle, AxisAligned) {
  compare({}, 101, 40, 20);
}
TEST(ContainOracle, JitteredRandom) {
  compare({.jitter = 0.3}, 102, 60, 20);
}
TEST(ContainOracle, JitteredDyadic) {
  compare({.jitter = 0.3, .snap = 0x1p-6}, 103, 80, 20);
}
TEST(ContainOracle, CoarseDyadic) {
  compare({.jitter = 0.4, .snap = 0.125}, 104, 120, 20);
}
TEST(ContainOracle, NearlyFlat) {
  compare({.jitter = 1e-15}, 105, 60, 20);
}
TEST(ContainOracle, SlightlyTwisted) {
  compare({.jitter = 1e-9, .snap = 0x1p-33}, 106, 60, 20);
}
TEST(ContainOracle, Offset) {
  compare({.jitter = 0.3, .offset = 1e7}, 107, 60, 20);
}
TEST(ContainOracle, OffsetDyadic) {
  compare({.jitter = 0.3, .offset = 1e7, .snap = 0x1p-8}, 108, 60, 20);
}
TEST(ContainOracle, Slivers) {
  compare({.jitter = 0.3, .scale = {1, 1, 1e-6}}, 109, 60, 20);
}
TEST(ContainOracle, SliversDyadicOffset) {
  compare({.jitter = 0.3, .offset = 1e7, .scale = {1e6, 1, 1}, .snap = 0x1p-8}, 110, 60, 20);
}
TEST(ContainOracle, Folded) {
  compare({.jitter = 1.5}, 111, 60, 20);
}
TEST(ContainOracle, FoldedDyadic) {
  compare({.jitter = 1.5, .snap = 0.25}, 112, 120, 20);
}
TEST(ContainOracle, Collapsed) {
  compare({.jitter = 0.2, .merged = 2}, 113, 60, 20);
}
TEST(ContainOracle, CollapsedDyadic) {
  compare({.jitter = 0.2, .snap = 0.125, .merged = 3}, 114, 120, 20);
}
TEST(ContainOracle, SmallIntegers) {
  compare({.integer = true}, 115, 250, 30);
}

} // namespace
} // namespace insitu::test
