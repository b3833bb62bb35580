#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "cells/kernels/kernels.h"
#include "commit/standins/dual_cells.h"
#include "core/random.h"
#include "query/lattice/dual_query.h"
#include "unit/query/registered_amr.h"

/// Stitching cells that are answered by their places: frusta and boxes, against the tree, which
/// decides by the filter, Newton's method and exact arithmetic.
namespace insitu::test {
namespace {

using math::Vec3d;

/// A dual mesh whose finder is at hand.
struct Dual {
  explicit Dual(const Recipe& recipe)
      : mesh(recipe, INSITU_DUAL, [](const Vec3d& p) { return p.x; }), cells(memory) {
    cells.build(mesh.committed.mesh.mesh(), mesh.committed.threads, amr::Cubes::gridlets);
  }

  const mesh::MeshView& view() const { return cells.view(); }
  const amr::LeafMap& leaves() const { return cells.dual().leaves(); }
  query::DualPlaces places(const std::uint64_t* shown = nullptr) const {
    return {&cells.places(), &cells.dual().corners(), shown};
  }
  std::int64_t first() const { return view().first_cell[1]; }
  /// The tree's alone.
  query::Sampler by_tree() const { return {view(), mesh.committed.mesh.tree()}; }

  core::Memory memory;
  RegisteredAmr mesh;
  commit::DualCells cells;
};

/// Points, and how they were answered.
struct Seen {
  int tried = 0, inside = 0, found = 0, guessed = 0, right = 0, frusta = 0, missed = 0;
};

Vec3d at_parametric(const mesh::CellVertices& cell, const Vec3d& r) {
  double w[8];
  cells::shape_functions(cell.shape, r, w);
  Vec3d p;
  for (int v = 0; v < cell.count; ++v)
    p += w[v] * cell.x[v];
  return p;
}

/// Whether the vertices lie in two planes across an axis, as the corners of a rectangle, the ends
/// of a side or a point in each, as far apart as centres of leaves whose depths differ by one.
bool is_frustum(const mesh::CellVertices& cell, const mesh::Lattice& lattice) {
  for (int axis = 0; axis < 3; ++axis) {
    std::map<double, std::set<std::pair<double, double>>> planes;
    for (int v = 0; v < cell.count; ++v)
      planes[cell.x[v][axis]].insert({cell.x[v][(axis + 1) % 3], cell.x[v][(axis + 2) % 3]});
    if (planes.size() != 2)
      continue;
    bool rectangles = true;
    for (const auto& [place, corners] : planes) {
      std::set<double> x, y;
      for (const auto& c : corners) {
        x.insert(c.first);
        y.insert(c.second);
      }
      rectangles &= x.size() <= 2 && y.size() <= 2 && corners.size() == x.size() * y.size();
    }
    const double apart = planes.rbegin()->first - planes.begin()->first;
    for (int depth = 0; rectangles && depth < 8; ++depth)
      if (std::fabs(apart - 1.5 * lattice.width(axis, depth)) < 1e-6 * apart)
        return true;
  }
  return false;
}

/// Whether it has a vertex on the boundary of the domain, which is a box.
bool is_cut(const mesh::CellVertices& cell, const accel::Tree& tree) {
  bool cut = false;
  for (int v = 0; v < cell.count; ++v)
    for (int a = 0; a < 3; ++a)
      cut |= std::fabs(cell.x[v][a] - tree.bounds_min()[a]) < 1e-6 ||
             std::fabs(cell.x[v][a] - tree.bounds_max()[a]) < 1e-6;
  return cut;
}

/// By axis, some roundings of the cell's extent and of coordinates there: those of finding the
/// place and of summing it up again.
Vec3d slack(const mesh::CellVertices& cell, const Vec3d& origin) {
  Vec3d out;
  for (int a = 0; a < 3; ++a) {
    double low = cell.x[0][a], high = low, far = 0.0;
    for (int v = 0; v < cell.count; ++v) {
      low = std::fmin(low, cell.x[v][a]);
      high = std::fmax(high, cell.x[v][a]);
      far = std::fmax(far, std::fabs(cell.x[v][a]) + std::fabs(cell.x[v][a] - origin[a]));
    }
    out[a] = 0x1p-53 * 16 * (high - low + far);
  }
  return out;
}

class Frusta : public testing::TestWithParam<Recipe> {};

/// Points in stitching cells, on their faces, edges and corners and one unit in the last place
/// beside these: what is found by place is the tree's answer, with coordinates that map back.
TEST_P(Frusta, AnswersAreTheTrees) {
  Dual dual(GetParam());
  const mesh::MeshView& view = dual.view();
  const query::Sampler tree = dual.by_tree();
  const mesh::Lattice& lattice = dual.leaves().lattice();
  const Vec3d origin = {lattice.origin[0], lattice.origin[1], lattice.origin[2]};
  const std::int64_t stitching = view.cell_count() - dual.first();
  if (stitching == 0)
    return;
  query::DualFinder finder(dual.places());
  Seen seen;
  for (int i = 0; i < 6000; ++i) {
    const auto r = [&](int c) {
      return core::random_unit(77 + GetParam().seed, std::uint64_t(i), std::uint64_t(c));
    };
    mesh::CellVertices cell;
    mesh::gather(view, dual.first() + std::int64_t(r(0) * double(stitching)), cell);
    Vec3d at;
    for (int a = 0; a < 3; ++a) { // within, or at 0, 1/2 or 1, where faces and diagonals are
      const int where = i % 2 ? int(6 * r(1 + a)) : 5;
      at[a] = where < 3 ? 0.5 * where : r(4 + a);
    }
    if (cell.shape == mesh::Shape::tetrahedron || cell.shape == mesh::Shape::wedge)
      at.y = std::fmin(at.y, 1.0 - at.x);
    if (cell.shape == mesh::Shape::tetrahedron)
      at.z = std::fmin(at.z, 1.0 - at.x - at.y);
    Vec3d p = at_parametric(cell, at);
    if (i % 4 == 3)
      for (int a = 0; a < 3; ++a)
        p[a] = std::nextafter(p[a], r(7 + a) < 0.5 ? -1e9 : 1e9);
    query::Reason why, tree_why;
    query::Location found;
    std::int64_t guess = -1;
    const bool by_place = finder.find(p, found, why, guess);
    const query::Location expected = tree.locate(p, -1, {INSITU_EXACT, 1.0}, &tree_why);
    ++seen.tried;
    seen.inside += tree_why == query::Reason::certified;
    if (expected && expected.cell >= dual.first()) {
      mesh::CellVertices owner;
      mesh::gather(view, expected.cell, owner);
      // Points well inside; but frusta that the domain's boundary cuts go to the tree.
      if (i % 2 == 0 && GetParam().kind <= 1 && !is_cut(owner, dual.mesh.committed.mesh.tree()) &&
          tree_why == query::Reason::certified && is_frustum(owner, lattice)) {
        ++seen.frusta;
        seen.missed += !by_place;
      }
    }
    if (!by_place) {
      seen.guessed += guess >= 0;
      seen.right += guess >= 0 && guess == expected.cell;
      ASSERT_LT(guess, view.cell_count());
      continue;
    }
    seen.found += tree_why == query::Reason::certified;
    ASSERT_EQ(found.cell, expected.cell) << GetParam().name() << " point " << i;
    const auto proof = [](query::Reason w) { // by bounds or by exact arithmetic
      return w == query::Reason::exact ? query::Reason::certified : w;
    };
    EXPECT_EQ(proof(why), proof(tree_why)) << GetParam().name() << " point " << i;
    mesh::CellVertices owner;
    mesh::gather(view, found.cell, owner);
    const Vec3d back = at_parametric(owner, found.parametric);
    const Vec3d most = slack(owner, origin);
    for (int a = 0; a < 3; ++a)
      ASSERT_NEAR(back[a], p[a], most[a])
          << GetParam().name() << " point " << i << " axis " << a << " shape " << int(owner.shape);
  }
  // Beside an edge of a level the guess may be at another cell; and the leaf map, which says where
  // to look, does not know of leaves that were split.
  const bool split = dual.cells.dual().counts().repaired > 0;
  EXPECT_LE(seen.missed, (split ? 0.12 : 0.05) * seen.frusta) << seen.frusta;
  EXPECT_GT(seen.found, 0) << seen.inside;
  if (seen.guessed > 100) {
    EXPECT_GT(seen.right, 0.25 * seen.guessed) << seen.guessed;
  }
}

TEST_P(Frusta, TheWayToALeafIsTheLeafMaps) {
  const Dual dual(GetParam());
  if (dual.leaves().leaf_count() == 0)
    return;
  const query::GridletPlaces& places = dual.cells.places();
  const amr::LeafMap& leaves = dual.leaves();
  const accel::Tree& tree = dual.mesh.committed.mesh.tree();
  std::int64_t seen[3] = {0, 0, 0}, first[3], last[3], at[3];
  for (int depth = 0; depth < places.depth_count(); ++depth) {
    for (int a = 0; a < 3; ++a) { // and some beyond the domain
      const double width = leaves.lattice().width(a, depth);
      first[a] =
          std::int64_t(std::floor((tree.bounds_min()[a] - leaves.lattice().origin[a]) / width)) - 9;
      last[a] =
          std::int64_t(std::ceil((tree.bounds_max()[a] - leaves.lattice().origin[a]) / width)) + 9;
    }
    for (at[2] = first[2]; at[2] < last[2]; ++at[2])
      for (at[1] = first[1]; at[1] < last[1]; ++at[1])
        for (at[0] = first[0]; at[0] < last[0]; ++at[0]) {
          const std::uint32_t entry = leaves.at(depth, at);
          const int way = entry == amr::LeafMap::nothing   ? -1
                          : entry == amr::LeafMap::refined ? 1
                                                           : 0;
          ++seen[way + 1];
          ASSERT_EQ(places.way_to_leaf(depth, at), way)
              << "depth " << depth << ": " << at[0] << " " << at[1] << " " << at[2];
        }
  }
  EXPECT_GT(seen[0], 0);
  EXPECT_GT(seen[1], 0);
}

/// With some cells left out, these and none else are answered as outside.
TEST_P(Frusta, ThoseThatAreNotShownAreOutside) {
  Dual dual(GetParam());
  const mesh::MeshView& view = dual.view();
  const std::int64_t gridlets = dual.cells.places().gridlets().count;
  const std::int64_t stitching = view.cell_count() - dual.first();
  std::vector<std::uint64_t> shown(std::size_t(gridlets + stitching + 63) / 64);
  for (std::size_t w = 0; w < shown.size(); ++w)
    shown[w] = core::random_bits(5, w, 0);
  query::DualFinder all(dual.places()), some(dual.places(shown.data()));
  for (std::int64_t c = 0; c < stitching; c += 1 + stitching / 3000) {
    mesh::CellVertices cell;
    mesh::gather(view, dual.first() + c, cell);
    Vec3d p;
    for (int v = 0; v < cell.count; ++v)
      p += (1.0 / cell.count) * cell.x[v];
    query::Reason why, why_some;
    query::Location at, at_some;
    std::int64_t guess = -1, guess_some = -1;
    const bool found = all.find(p, at, why, guess);
    ASSERT_EQ(some.find(p, at_some, why_some, guess_some), found);
    const auto shows = [&](std::int64_t flat) {
      const std::int64_t bit =
          flat < dual.first() ? flat >> mesh::Gridlet::cell_bits : gridlets + flat - dual.first();
      return (shown[std::size_t(bit >> 6)] >> (bit & 63) & 1) != 0;
    };
    if (found) {
      EXPECT_EQ(at_some.cell, shows(at.cell) ? at.cell : -1);
      EXPECT_EQ(why_some, shows(at.cell) ? why : query::Reason::outside);
    }
    if (guess_some >= 0) {
      EXPECT_TRUE(shows(guess_some));
    }
  }
}

TEST(FrustaOf, NoNumberAndFarPointsAreNowhere) {
  Dual dual({.seed = 2, .kind = 0, .roots = 2, .levels = 3});
  query::DualFinder finder(dual.places());
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = HUGE_VAL;
  for (const double x : {nan, infinite, -infinite, 1e300, -1e300, 1e12})
    for (int a = 0; a < 3; ++a) {
      Vec3d p = dual.mesh.committed.mesh.tree().bounds_min();
      p[a] = x;
      query::Location at;
      query::Reason why;
      std::int64_t guess = -1;
      EXPECT_FALSE(finder.find(p, at, why, guess)) << x << " axis " << a;
      EXPECT_LT(guess, 0);
    }
}

std::vector<Recipe> recipes() {
  std::vector<Recipe> all;
  for (int kind = 0; kind < 6; ++kind)
    for (std::uint64_t seed = 1; seed <= 3; ++seed)
      all.push_back({.seed = seed, .kind = kind, .roots = 2, .levels = 3});
  all.push_back({.seed = 9, .kind = 5, .roots = 2, .levels = 7}); // levels differ by up to six
  return all;
}

INSTANTIATE_TEST_SUITE_P(Random, Frusta, testing::ValuesIn(recipes()), [](const auto& of) {
  return "kind" + std::to_string(of.param.kind) + "_seed" + std::to_string(of.param.seed);
});

} // namespace
} // namespace insitu::test
