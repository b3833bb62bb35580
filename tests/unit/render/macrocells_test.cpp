#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>

#include "core/status.h"
#include "render/volume/macrocells.h"
#include "render/volume/possible_values.h"
#include "render/volume/whole_grid.h"
#include "unit/query/ghosted_amr.h"
#include "unit/render/placed_mesh.h"

namespace insitu::test {
namespace {

using render::MacrocellGrid;
using render::Macrocells;
using render::ScalarField;

double random(std::uint64_t a, std::uint64_t b, std::uint64_t c = 0) {
  return core::random_unit(77, a, b + (c << 32));
}

/// Every point of every cell is in a macrocell that counts the value there; what a macrocell says
/// is taken by a vertex of some cell whose box, with its margin, meets it.
void expect_bounds(const query::Sampler& sampler, const ScalarField& field,
                   const Macrocells& cells) {
  const mesh::MeshView& mesh = sampler.mesh();
  const MacrocellGrid& grid = cells.grid();
  std::vector<Macrocells::Range> oracle(std::size_t(grid.count()), {HUGE_VAL, -HUGE_VAL});
  mesh::CellVertices cell;
  double largest = 0;
  std::int64_t missed = 0, owned = 0;
  for (std::int64_t flat = 0; flat < mesh.cell_count(); ++flat) {
    const std::int32_t p = mesh.piece_of(flat);
    if (!mesh.pieces[p].owns(flat - mesh.first_cell[p]))
      continue;
    ++owned;
    mesh::gather(mesh, flat, cell);
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int v = 0; v < cell.count; ++v) {
      const double f = field.field.association == INSITU_CELL
                           ? field.load(p, flat - mesh.first_cell[p])
                           : field.load(p, cell.ids[v]);
      low = std::min(low, f);
      high = std::max(high, f);
    }
    largest = std::max({largest, std::fabs(low), std::fabs(high)});
    std::vector<int> met[3]; // layers that its box meets, each looked at
    for (int a = 0; a < 3; ++a) {
      double below = HUGE_VAL, above = -HUGE_VAL;
      for (int v = 0; v < cell.count; ++v) {
        below = std::min(below, cell.x[v][a]);
        above = std::max(above, cell.x[v][a]);
      }
      const double slack = 1.01 * Macrocells::margin * grid.size[a];
      for (int i = 0; i < grid.counts[a]; ++i)
        if ((i == 0 || above >= grid.plane(a, i) - slack) &&
            (i + 1 == grid.counts[a] || below <= grid.plane(a, i + 1) + slack))
          met[a].push_back(i);
    }
    for (const int k : met[2])
      for (const int j : met[1])
        for (const int i : met[0]) {
          Macrocells::Range& range = oracle[std::size_t(grid.index(i, j, k))];
          range.lower = std::min(range.lower, low);
          range.upper = std::max(range.upper, high);
        }
    // Points in the cell: convex combinations of its vertices.
    for (int k = 0; k < 8; ++k) {
      Vec3d x;
      double sum = 0;
      for (int v = 0; v < cell.count; ++v) {
        const double w = -std::log(1e-9 + random(std::uint64_t(flat), std::uint64_t(k * 8 + v)));
        x += w * cell.x[v];
        sum += w;
      }
      const Macrocells::Range& range = cells.range(grid.index(x / sum));
      missed += range.lower > low || range.upper < high;
    }
    for (int v = 0; v < cell.count; ++v) {
      const Macrocells::Range& range = cells.range(grid.index(cell.x[v]));
      missed += range.lower > low || range.upper < high;
    }
  }
  EXPECT_GT(owned, 0);
  EXPECT_EQ(missed, 0);
  std::int64_t wide = 0;
  for (std::int64_t m = 0; m < grid.count(); ++m) {
    const Macrocells::Range& is = cells.range(m);
    const Macrocells::Range& o = oracle[std::size_t(m)];
    const double slack = o.lower <= o.upper ? 1.1e-6 * (o.upper - o.lower) + 1e-13 * largest : 0;
    wide += is.lower < o.lower - slack || is.upper > o.upper + slack;
  }
  EXPECT_EQ(wide, 0);
}

class MacrocellShapes : public testing::TestWithParam<std::tuple<Shape, insitu_association>> {};

TEST_P(MacrocellShapes, RangesHoldAndAreNoWiderThanTheirCells) {
  const auto [shape, association] = GetParam();
  RenderMesh mesh(6, shape, 0.3);
  const auto field = mesh.field(
      "f", association, [](const Vec3d& p) { return std::sin(9 * p.x) * std::cos(7 * p.y) + p.z; });
  for (const double each : {1e9, 64.0, 4.0, 0.5}) {
    const Macrocells cells(mesh.sampler(), field, mesh.committed.threads, mesh.committed.memory,
                           each);
    expect_bounds(mesh.sampler(), field, cells);
    EXPECT_LE(double(cells.grid().count()), std::max(1.0, double(mesh.cells.cells.size()) / each));
    if (each == 1e9)
      EXPECT_EQ(cells.grid().count(), 1);
    else
      EXPECT_GE(double(cells.grid().count()), 0.1 * double(mesh.cells.cells.size()) / each);
  }
}

INSTANTIATE_TEST_SUITE_P(All, MacrocellShapes,
                         testing::Combine(testing::Values(Shape::hexahedron, Shape::tetrahedron,
                                                          Shape::wedge, Shape::pyramid),
                                          testing::Values(INSITU_VERTEX, INSITU_CELL)));

TEST(Macrocells, FarAwayFlatLongAndSingleCells) {
  struct Case {
    const char* what;
    int n;
    Vec3d scale, offset;
  };
  const Case cases[] = {{"far away", 5, {1, 1, 1}, {6.4e6, -6.4e6, 6.4e6}},
                        {"aspect 1e5", 5, {1e5, 1, 1}, {-3, 0, 0}},
                        {"aspect 1e5 far away", 5, {1e-2, 1e3, 10}, {6.4e6, 6.4e6, 0}},
                        {"without thickness", 5, {1, 1, 0}, {0, 0, 2}},
                        {"a line", 5, {0, 0, 1}, {1, 2, 3}},
                        {"one cell", 1, {2, 3, 4}, {0, 0, 0}},
                        {"tiny", 4, {1e-30, 1e-30, 1e-30}, {0, 0, 0}},
                        {"huge", 4, {1e30, 1e30, 1e30}, {0, 0, 0}}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.what);
    PlacedMesh mesh(placed(c.n, Shape::hexahedron, c.scale, c.offset));
    std::vector<double> values;
    for (std::size_t v = 0; v < mesh.cells.vertices.size(); ++v)
      values.push_back(random(v, 1));
    const ScalarField field = mesh.field(values);
    const Macrocells cells(mesh.committed.sampler(), field, mesh.committed.threads,
                           mesh.committed.memory, 4);
    expect_bounds(mesh.committed.sampler(), field, cells);
  }
}

/// Long cells across the mesh: their boxes fill it, and a fine grid would be all of them in each.
/// Thin tetrahedra, of which every so many-th is as long as the mesh, and oblique.
TestMesh needles(int count, int every) {
  TestMesh mesh;
  for (int i = 0; i < count; ++i) {
    MeshCell cell;
    cell.shape = Shape::tetrahedron;
    const Vec3d base{random(std::uint64_t(i), 2), random(std::uint64_t(i), 3), 0};
    const auto at = std::int32_t(mesh.vertices.size());
    const double e = 1e-5;
    const Vec3d top = i % every == 0 ? Vec3d{1 - base.x, 1 - base.y, 1} : base + Vec3d{0, 0, e};
    const Vec3d corners[4] = {base, base + Vec3d{e, 0, 0}, base + Vec3d{0, e, 0}, top};
    for (int v = 0; v < 4; ++v) {
      mesh.vertices.push_back(corners[v]);
      cell.vertices[std::size_t(v)] = at + v;
    }
    mesh.cells.push_back(cell);
  }
  return mesh;
}

TEST(Macrocells, ObliqueLongCellsDoNotTakeForever) {
  constexpr int count = 3000;
  PlacedMesh placed_mesh(needles(count, 1));
  const ScalarField field = placed_mesh.field(std::vector<double>(4 * count, 1.0));
  const Macrocells cells(placed_mesh.committed.sampler(), field, placed_mesh.committed.threads,
                         placed_mesh.committed.memory, 1e-3);
  EXPECT_LE(cells.grid().count(), 256 * 64);
}

/// Nor do they where few cells are long, on a grid that hangs on the whole mesh alone: it would
/// have 3 million macrocells, of which each long cell's box fills a quarter.
TEST(Macrocells, SomeLongCellsDoNotTakeForever) {
  constexpr int count = 3000;
  PlacedMesh placed_mesh(needles(count, 100));
  const query::Sampler sampler = placed_mesh.committed.sampler();
  const mesh::MeshFacts facts = sampler.facts();
  const MacrocellGrid grid = render::whole_grid(
      facts, render::cell_widths(sampler, facts.bounds, placed_mesh.committed.threads), 1e-3);
  EXPECT_GT(grid.count(), 1000);
  EXPECT_LE(grid.count(), 256 * 4 * 100); // 256 a cell, by those of a hundred that are long
}

/// A thousand of 64 cells each are ten layers along each axis, whatever roundings say.
TEST(Macrocells, GridsOfCubesHaveWholeRoots) {
  for (const int layers : {3, 5, 6, 7, 10, 12}) {
    const double across = 4 * layers * (1 - 1e-9);
    const MacrocellGrid grid = MacrocellGrid::over({{0, 0, 0}, {1, 1, 1}}, {across, across, across},
                                                   64.0 * layers * layers * layers, {});
    EXPECT_EQ(grid.counts, (std::array{layers, layers, layers}));
  }
}

TEST(Macrocells, AdaptiveMeshes) {
  for (int kind = 0; kind < 3; ++kind) {
    SCOPED_TRACE(kind);
    RegisteredAmr mesh({.seed = 2, .kind = kind, .roots = 3, .levels = 3}, INSITU_DUAL,
                       [](const Vec3d& p) { return p.x * p.x - p.y + 3 * p.z; });
    const ScalarField field{mesh.committed.mesh.mesh().field("f"), 0};
    const Macrocells cells(mesh.committed.sampler(), field, mesh.committed.threads,
                           mesh.committed.memory, 16);
    EXPECT_GT(cells.grid().count(), 8);
    expect_bounds(mesh.committed.sampler(), field, cells);
  }
}

/// Gridlets are taken as a whole, with the bits of their cells one by one.
TEST(Macrocells, OfGridletsAreThoseOfTheirCells) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto wave = [](const Vec3d& p) { return std::sin(3 * p.x) + p.y * p.z; };
  for (const double odd : {0.0, -0.0, nan, HUGE_VAL})
    for (int kind = 0; kind < 5; ++kind) {
      RegisteredAmr mesh(
          {.seed = 2, .kind = kind, .roots = 9, .levels = 2}, INSITU_DUAL, [&](const Vec3d& p) {
            const double share = odd == 0 ? 0.9 : 0.02;
            const bool is_odd = random(5, std::bit_cast<std::uint64_t>(p.x + p.z)) < share;
            return is_odd ? odd : wave(p);
          });
      const query::Sampler sampler = mesh.committed.sampler();
      const mesh::MeshView& view = sampler.mesh();
      const ScalarField field{mesh.committed.mesh.mesh().field("f"), 0};
      for (const double each : {0.01, 1.0, 30.0}) {
        SCOPED_TRACE(testing::Message() << odd << ", kind " << kind << ", " << each);
        const Macrocells cells(sampler, field, mesh.committed.threads, mesh.committed.memory, each);
        const MacrocellGrid& grid = cells.grid();
        std::vector<Macrocells::Range> expected(std::size_t(grid.count()), {HUGE_VAL, -HUGE_VAL});
        mesh::CellVertices cell;
        for (std::int64_t flat = 0; flat < view.cell_count(); ++flat) {
          mesh::gather(view, flat, cell);
          if (!view.pieces[cell.piece].owns(flat - view.first_cell[cell.piece]))
            continue;
          render::PossibleValues values;
          Vec3d low = cell.x[0], high = cell.x[0];
          for (int v = 0; v < cell.count; ++v) {
            values.add(field.load(cell.piece, cell.ids[v]));
            for (int a = 0; a < 3; ++a) {
              low[a] = std::min(low[a], cell.x[v][a]);
              high[a] = std::max(high[a], cell.x[v][a]);
            }
          }
          values.finish(true);
          int from[3], to[3];
          for (int a = 0; a < 3; ++a) {
            const auto layer = [&](double x, double margin) {
              const double at =
                  (x - grid.low[a]) * (grid.counts[a] > 1 ? 1 / grid.size[a] : 0.0) + margin;
              return std::clamp(int(at), 0, grid.counts[a] - 1);
            };
            from[a] = layer(low[a], -Macrocells::margin);
            to[a] = layer(high[a], Macrocells::margin);
          }
          for (int k = from[2]; k <= to[2]; ++k)
            for (int j = from[1]; j <= to[1]; ++j)
              for (int i = from[0]; i <= to[0]; ++i) {
                Macrocells::Range& range = expected[std::size_t(grid.index(i, j, k))];
                range.lower = std::min(range.lower, values.lower);
                range.upper = std::max(range.upper, values.upper);
              }
        }
        for (std::int64_t m = 0; m < grid.count(); ++m)
          ASSERT_EQ(std::memcmp(&cells.range(m), &expected[std::size_t(m)], sizeof expected[0]), 0)
              << m << ": " << cells.range(m).lower << " " << cells.range(m).upper << ", not "
              << expected[std::size_t(m)].lower << " " << expected[std::size_t(m)].upper;
      }
    }
}

/// Values between cells and the solver's ghosts beyond the domain are in the ranges.
TEST(Macrocells, GhostsOfAdaptiveMeshes) {
  const auto quadratic = [](const Vec3d& p) { return p.x * p.x - p.y + 3 * p.z; };
  for (int kind = 0; kind < 3; ++kind) {
    SCOPED_TRACE(kind);
    GhostedAmr mesh(
        {.seed = 2, .kind = kind, .roots = 3, .levels = 3},
        [](std::size_t) { return std::uint8_t(63); }, quadratic);
    const ScalarField field{mesh.committed.mesh.mesh().field("f"), 0};
    const Macrocells cells(mesh.committed.sampler(), field, mesh.committed.threads,
                           mesh.committed.memory, 16);
    EXPECT_GT(cells.grid().count(), 8);
    expect_bounds(mesh.committed.sampler(), field, cells);
    double most = -HUGE_VAL, most_of_cells = -HUGE_VAL;
    for (std::int64_t m = 0; m < cells.grid().count(); ++m)
      most = std::max(most, cells.range(m).upper);
    for (const Leaf& leaf : leaves_of(mesh.amr))
      most_of_cells = std::max(
          most_of_cells,
          quadratic(RegisteredAmr::centre_of(
              mesh.amr.view(), {leaf.depth, {leaf.index[0], leaf.index[1], leaf.index[2]}})));
    // Half of the coarsest cells' step along z at least.
    EXPECT_GT(most, most_of_cells + 0.1 * mesh.amr.lattice.spacing[2]);
  }
}

TEST(Macrocells, ValuesThatAreNoNumbersAndBeyondFloat) {
  PlacedMesh mesh(placed(6, Shape::hexahedron, {1, 1, 1}, {0, 0, 0}));
  const std::size_t n = mesh.cells.vertices.size();
  for (const double size : {1e-300, 5e-324, 1e300}) {
    SCOPED_TRACE(size);
    std::vector<double> values;
    for (std::size_t v = 0; v < n; ++v)
      values.push_back(size * std::floor(3 * random(v, 5)));
    const ScalarField field = mesh.field(values);
    const Macrocells cells(mesh.committed.sampler(), field, mesh.committed.threads,
                           mesh.committed.memory, 4);
    expect_bounds(mesh.committed.sampler(), field, cells);
    EXPECT_FALSE(cells.has_nan(0));
  }
  // One NaN, in the corner of the mesh: it marks, and its cell counts for no range.
  std::vector<double> values(n, 2.0);
  values[0] = std::nan("");
  values[1] = 7.0;
  values[n - 1] = HUGE_VAL;
  const ScalarField field = mesh.field(values);
  const Macrocells cells(mesh.committed.sampler(), field, mesh.committed.threads,
                         mesh.committed.memory, 1);
  const std::int64_t last = cells.grid().count() - 1;
  EXPECT_TRUE(cells.has_nan(0));
  EXPECT_NEAR(cells.range(0).upper, 7, 1e-4); // of the cell beside
  EXPECT_TRUE(cells.has_nan(last));           // infinite times 0
  EXPECT_EQ(cells.range(last).upper, HUGE_VAL);
  std::int64_t marked = 0;
  for (std::int64_t m = 0; m <= last; ++m)
    marked += cells.has_nan(m);
  EXPECT_LE(marked, 16);
  // Nothing but NaN: no range at all.
  const Macrocells none(mesh.committed.sampler(), mesh.field(std::vector<double>(n, values[0])),
                        mesh.committed.threads, mesh.committed.memory);
  EXPECT_GT(none.range(0).lower, none.range(0).upper);
  EXPECT_TRUE(none.has_nan(0));
}

TEST(Macrocells, SameForAnyNumberOfThreads) {
  RenderMesh mesh(14, Shape::tetrahedron, 0.3);
  const auto field = mesh.field("f", INSITU_VERTEX, [](const Vec3d& p) {
    return p.x < 0.5 ? (p.y < 0.5 ? -0.0 : 0.0) : std::sin(30 * p.x * p.y); // both zeros
  });
  const auto bytes = [&](int threads) {
    const Macrocells cells(mesh.sampler(), field, core::Threads(threads), mesh.committed.memory, 8);
    std::vector<char> all(std::size_t(cells.grid().count()) * sizeof(Macrocells::Range));
    std::memcpy(all.data(), &cells.range(0), all.size());
    return all;
  };
  const std::vector<char> one = bytes(1);
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(bytes(4), one);
}

TEST(Macrocells, RefreshTakesNewValuesWithoutMemory) {
  RenderMesh mesh(8);
  const auto first = mesh.field("f", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  Macrocells cells(mesh.sampler(), first, mesh.committed.threads, mesh.committed.memory, 8);
  const auto second = mesh.field("f", INSITU_VERTEX, [](const Vec3d& p) { return 5 - p.y; });
  const std::int64_t before = mesh.committed.memory.current();
  mesh.committed.memory.reset_peak();
  cells.refresh(mesh.sampler(), second, mesh.committed.threads);
  EXPECT_EQ(mesh.committed.memory.current(), before);
  EXPECT_EQ(mesh.committed.memory.peak(), before);
  expect_bounds(mesh.sampler(), second, cells);
  const Macrocells anew(mesh.sampler(), second, mesh.committed.threads, mesh.committed.memory, 8);
  for (std::int64_t m = 0; m < cells.grid().count(); ++m) {
    EXPECT_EQ(cells.range(m).lower, anew.range(m).lower);
    EXPECT_EQ(cells.range(m).upper, anew.range(m).upper);
  }
  EXPECT_THROW(Macrocells(mesh.sampler(), second, mesh.committed.threads, mesh.committed.memory, 0),
               core::Error);
}

} // namespace
} // namespace insitu::test
