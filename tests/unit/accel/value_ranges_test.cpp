// Value ranges hold every value below a child, and little more.
#include <gtest/gtest.h>

#include "accel/tree/value_ranges.h"
#include "fixtures/committed.h"

using namespace insitu;
using accel::ValueRanges;

namespace {

struct Range {
  double lo = HUGE_VAL, hi = -HUGE_VAL;
  void add(double v) {
    if (std::isnan(v))
      return;
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
};

struct Fixture {
  fixtures::Committed m;
  std::vector<double> values;

  Fixture(insitu_association association, int components, double scale)
      : m(test::make_mesh({.kind = test::MeshKind::mixed, .size = 6}, 61)) {
    const std::int64_t n =
        association == INSITU_CELL ? m.arrays.cell_count() : m.arrays.vertex_count();
    test::Random random(62);
    for (std::int64_t i = 0; i < n * components; ++i)
      values.push_back(scale * random.uniform(-1, 1));
    const insitu_array a = insitu_array_of(values.data(), INSITU_FLOAT64, n, components);
    m.mesh.mesh().set_field(0, "f", association, &a, 1);
    m.commit();
  }

  void check(int component) {
    const mesh::MeshView& view = m.mesh.mesh().view();
    const accel::Tree& tree = m.mesh.tree();
    const mesh::FieldView field = m.mesh.mesh().field("f");
    const ValueRanges ranges(tree, view, field, component, m.threads, m.memory);
    const auto value = [&](std::int64_t item) {
      if (component >= 0)
        return field.pieces[0].load(item, component);
      double sum = 0;
      for (int c = 0; c < field.components; ++c)
        sum += field.pieces[0].load(item, c) * field.pieces[0].load(item, c);
      return std::sqrt(sum);
    };
    const auto cell_range = [&](std::int64_t cell, Range& r) {
      if (field.association == INSITU_CELL)
        return r.add(value(cell));
      mesh::CellVertices vertices;
      mesh::gather(view, cell, vertices);
      for (int v = 0; v < vertices.count; ++v)
        r.add(value(vertices.ids[v]));
    };
    // Bottom up: children of a level lie in the next.
    std::vector<std::array<Range, 8>> expected(tree.node_count());
    for (std::uint32_t n = tree.node_count(); n-- > 0;)
      for (int c = 0; c < 8; ++c) {
        const accel::Node& node = tree.nodes()[n];
        const auto may_contain = [&](float low, float high) {
          return (ranges.may_contain(n, low, high) >> c & 1) != 0;
        };
        Range& r = expected[n][std::size_t(c)];
        if (!node.meta[c])
          continue;
        if (node.is_inner(c))
          for (const Range& below : expected[node.child_node(c)]) {
            r.lo = std::min(r.lo, below.lo);
            r.hi = std::max(r.hi, below.hi);
          }
        else
          for (int k = 0; k < node.child_cell_count(c); ++k)
            cell_range(tree.cells()[node.child_cells(c) + std::uint32_t(k)], r);
        if (r.lo > r.hi) { // no value at all
          EXPECT_FALSE(may_contain(-1e38f, 1e38f));
          continue;
        }
        // Each end is found, by floats on either side of it.
        for (const double end : {r.lo, r.hi}) {
          const float nearest = float(end);
          ASSERT_TRUE(may_contain(nearest, nearest)) << "node " << n << " " << end;
        }
        if (std::fabs(r.lo) < 1e38 && std::fabs(r.hi) < 1e38) {
          const double slack_lo = std::fabs(r.lo) * 0x1p-20 + 1e-36,
                       slack_hi = std::fabs(r.hi) * 0x1p-20 + 1e-36;
          ASSERT_FALSE(may_contain(-INFINITY, float(r.lo - slack_lo)));
          ASSERT_FALSE(may_contain(float(r.hi + slack_hi), INFINITY));
        }
      }
    Range all;
    for (const Range& r : expected[0]) {
      all.lo = std::min(all.lo, r.lo);
      all.hi = std::max(all.hi, r.hi);
    }
    EXPECT_LE(double(ranges.min()), all.lo);
    EXPECT_GE(double(ranges.max()), all.hi);
  }
};

} // namespace

TEST(ValueRanges, HoldEveryValueAndLittleMore) {
  for (const auto association : {INSITU_VERTEX, INSITU_CELL})
    for (const double scale : {1.0, 1e-30, 1e30, 1e-40})
      for (const int components : {1, 3}) {
        Fixture f(association, components, scale);
        for (int c = -1; c < components; ++c)
          f.check(c);
      }
}

TEST(ValueRanges, LeaveNaNOutAndKeepWhatNoFloatHolds) {
  for (const auto association : {INSITU_VERTEX, INSITU_CELL}) {
    Fixture f(association, 1, 1.0);
    for (std::size_t i = 0; i < f.values.size(); ++i)
      if (i % 3 == 0)
        f.values[i] = i % 2 ? 1e300 : (i % 4 ? NAN : -1e300);
    f.check(0);
    std::fill(f.values.begin(), f.values.end(), NAN);
    const ValueRanges none(f.m.mesh.tree(), f.m.mesh.mesh().view(), f.m.mesh.mesh().field("f"), 0,
                           f.m.threads, f.m.memory);
    EXPECT_GT(none.min(), none.max());
    std::fill(f.values.begin(), f.values.end(), HUGE_VAL);
    f.check(0);
    std::fill(f.values.begin(), f.values.end(), -HUGE_VAL);
    f.check(0);
  }
}
