// Rows of points through adaptive meshes: with the bits of each point alone.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "amr/leaves/leaf_map.h"
#include "core/random.h"
#include "fixtures/simd_targets.h"
#include "unit/query/registered_amr.h"

namespace insitu::test {
namespace {

using math::Vec3d;

double wave(const Vec3d& p) {
  return std::sin(p.x) + p.y * p.z;
}

/// Rows along an axis through a place of the lattice's numbers or any, by whole parts of cells, or
/// not; some rows end beside the mesh or in NaN.
std::vector<Vec3d> rows_through(RegisteredAmr& mesh, std::uint64_t seed) {
  const query::Sampler sampler = mesh.committed.sampler();
  const mesh::AmrView& view = mesh.amr.view();
  const int finest = view.finest_depth();
  const Vec3d low = sampler.tree().bounds_min(), high = sampler.tree().bounds_max();
  std::vector<Vec3d> points;
  for (int row = 0; row < 60; ++row) {
    const auto r = [&](int c) {
      return core::random_unit(seed, std::uint64_t(row), std::uint64_t(c));
    };
    const int axis = row % 3, parts = 1 + row % 5;
    Vec3d p;
    for (int a = 0; a < 3; ++a) {
      const auto halves =
          std::int64_t((low[a] + r(a) * (high[a] - low[a]) - view.lattice.origin[a]) /
                       view.lattice.width(a, finest + 1));
      p[a] = row % 4 ? view.lattice.place(a, finest, halves) : low[a] + r(a) * (high[a] - low[a]);
    }
    if (row % 5 == 3) { // among the cells that end at the domain's boundary
      const int across = (axis + 1 + row % 2) % 3;
      const double depth = 0.49 * r(3) * view.lattice.width(across, finest);
      p[across] = row % 10 == 3 ? low[across] + depth : high[across] - depth;
    }
    constexpr double stretch[] = {0.83, 1.0, 1.6, 1.0, 4.0, 1.0, 1.0};
    const double step = view.lattice.width(axis, finest) / parts * stretch[row % 7];
    const double start = row % 2 ? p[axis] : low[axis] - step;
    for (int i = 0; i < 20 * parts; ++i) {
      p[axis] = start + i * step;
      points.push_back(p);
    }
    if (row % 11 == 0)
      points.back().x = std::numeric_limits<double>::quiet_NaN();
  }
  return points;
}

/// Points that follow each other go many at a time, or are looked for in cells like the last one's:
/// with the bits of each alone, in all SIMD targets.
void expect_rows_as_alone(RegisteredAmr& mesh, insitu_reconstruction reconstruction,
                          std::uint64_t seed, const std::string& name) {
  const query::Sampler sampler = mesh.committed.sampler();
  const std::vector<Vec3d> points = rows_through(mesh, seed);
  std::vector<query::Location> alone(points.size());
  std::vector<query::Reason> why(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    alone[i] = sampler.locate(points[i], -1, {}, &why[i]);
  for (const std::int64_t target : fixtures::simd_targets()) {
    fixtures::use_simd_target(target);
    std::vector<query::Location> rows(points.size());
    std::vector<std::uint8_t> reasons(points.size());
    sampler.locate(mesh.committed.threads, points, rows, {}, reasons);
    fixtures::use_simd_target(0);
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(rows[i].cell, alone[i].cell) << name << ", " << reconstruction << " point " << i;
      ASSERT_EQ(rows[i].parametric, alone[i].parametric)
          << name << ", " << reconstruction << " point " << i;
      const bool both_proven = why[i] <= query::Reason::exact && reconstruction == INSITU_DUAL;
      ASSERT_TRUE(reasons[i] == std::uint8_t(why[i]) || (both_proven && alone[i]))
          << name << ", " << reconstruction << " point " << i << ": " << int(reasons[i]) << " "
          << int(why[i]);
    }
  }
}

TEST(AdaptiveRows, RandomMeshesAnswerAsEachPointAlone) {
  std::vector<Recipe> recipes;
  for (int kind = 0; kind < 6; ++kind)
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
      recipes.push_back({.seed = seed, .kind = kind, .roots = 2, .levels = 3});
  for (std::uint64_t seed = 1; seed <= 2; ++seed) { // jumps of up to six levels
    recipes.push_back({.seed = seed, .kind = 5, .roots = 1, .levels = 7});
    recipes.push_back({.seed = seed, .kind = 0, .roots = 1, .levels = 5});
  }
  for (int kind = 0; kind < 3; ++kind)
    recipes.push_back({.seed = 5, .kind = kind, .roots = 2, .levels = 3, .far = true});
  for (const Recipe& recipe : recipes) {
    AmrMesh made = make_mesh(recipe);
    if (leaves_of(made).empty())
      continue;
    for (const auto reconstruction : {INSITU_DUAL, INSITU_NEAREST}) {
      RegisteredAmr mesh(recipe, reconstruction, wave);
      expect_rows_as_alone(mesh, reconstruction, recipe.seed, recipe.name());
    }
  }
}

// ---- bricks whose ids are sums of numbers along the axes (amr/leaves/brick_numbering.h)

/// A box of two levels: 32 x 16 x 16 coarse cells, of which 8 x 8 x 8 are refined.
std::vector<std::pair<int, Index>> leaves_in_rows() {
  std::vector<std::pair<int, Index>> leaves;
  for (std::int64_t k = 0; k < 16; ++k)
    for (std::int64_t j = 0; j < 16; ++j)
      for (std::int64_t i = 0; i < 32; ++i)
        if (i < 8 || i >= 16 || j < 8 || k >= 8)
          leaves.push_back({0, {i, j, k}});
  for (std::int64_t k = 0; k < 16; ++k)
    for (std::int64_t j = 16; j < 32; ++j)
      for (std::int64_t i = 16; i < 32; ++i)
        leaves.push_back({1, {i, j, k}});
  return leaves;
}
std::uint64_t morton(const Index& at) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < 8; ++bit)
    for (std::size_t a = 0; a < 3; ++a)
      code |= (std::uint64_t(at[a] >> bit) & 1) << (3 * bit + int(a));
  return code;
}
AmrMesh mesh_of(const std::vector<std::pair<int, Index>>& leaves) {
  AmrMesh mesh;
  mesh.depth_of = {0, 1};
  for (const auto& [level, corner] : leaves)
    mesh.add_leaf(level, corner);
  return mesh;
}

/// sums: bricks whose ids are, of the 15 coarse and 8 fine ones.
void expect_bricks(AmrMesh made, std::int64_t sums, const std::string& name) {
  core::Memory memory;
  amr::LeafMap map(memory);
  map.build(made.view(), core::Threads(1));
  map.number_bricks(core::Threads(1));
  EXPECT_EQ(map.numbering().numbered_count(), sums) << name;
  for (const std::uint64_t seed : {1, 2}) {
    RegisteredAmr mesh(made, INSITU_NEAREST, wave);
    expect_rows_as_alone(mesh, INSITU_NEAREST, seed, name);
  }
}

TEST(AdaptiveRows, BricksOfPatches) {
  AmrMesh mesh;
  mesh.depth_of = {0, 1};
  mesh.add_patch(1, {16, 16, 0}, {16, 16, 16});
  mesh.add_patch(0, {16, 0, 0}, {16, 16, 16});
  mesh.add_patch(0, {0, 0, 0}, {16, 16, 16}); // covered in part, in one brick
  expect_bricks(mesh, 15 + 8, "patches");
}

TEST(AdaptiveRows, BricksOfLeavesInAnyOrder) {
  auto leaves = leaves_in_rows();
  expect_bricks(mesh_of(leaves), 15 + 8, "rows");
  std::stable_sort(leaves.begin(), leaves.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first, morton(a.second)) < std::pair(b.first, morton(b.second));
  });
  expect_bricks(mesh_of(leaves), 15 + 8, "Morton order");
  std::reverse(leaves.begin(), leaves.end());
  expect_bricks(mesh_of(leaves), 15 + 8, "Morton order, reversed");
  std::swap(leaves[100], leaves[101]); // of a fine brick
  expect_bricks(mesh_of(leaves), 15 + 7, "but for two leaves");
  for (std::size_t i = leaves.size() - 1; i > 0; --i)
    std::swap(leaves[i], leaves[std::size_t(core::random_bits(4, i, 0) % (i + 1))]);
  expect_bricks(mesh_of(leaves), 0, "shuffled");
}

} // namespace
} // namespace insitu::test
