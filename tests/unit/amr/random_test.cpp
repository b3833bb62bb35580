// Random meshes: what must hold for all of them, and the smallest one for which it does not.
#include <gtest/gtest.h>

#include "check_dual.h"

using namespace insitu;
using test::Recipe;

namespace {

struct Sums {
  std::int64_t meshes = 0, stitching = 0, folded = 0, repaired = 0, still = 0;
};

/// Whether the mesh has two coarsest cells along every axis.
bool two_wide(test::AmrMesh& mesh) {
  test::Index lower = {INT64_MAX, INT64_MAX, INT64_MAX}, upper = {INT64_MIN, INT64_MIN, INT64_MIN};
  for (const test::Leaf& l : test::leaves_of(mesh))
    for (std::size_t a = 0; a < 3; ++a) {
      lower[a] = std::min(lower[a], l.index[a] >> l.depth);
      upper[a] = std::max(upper[a], l.index[a] >> l.depth);
    }
  return lower[0] < upper[0] && lower[1] < upper[1] && lower[2] < upper[2];
}

std::string problem_of(const Recipe& recipe, test::Expect expect, Sums* sums = nullptr) {
  test::AmrMesh mesh = test::make_mesh(recipe);
  if (expect.ghosts)
    mesh.give_ghosts();
  else
    expect.linear &= test::is_box(recipe) && two_wide(mesh);
  core::Memory memory;
  amr::DualMesh dual(memory);
  dual.build(mesh.view(), core::Threads(1));
  if (sums) {
    ++sums->meshes;
    sums->stitching += dual.counts().stitching();
    sums->folded += dual.counts().folded;
    sums->repaired += dual.counts().repaired;
    sums->still += dual.counts().still_folded;
  }
  return test::check_dual(mesh, dual, expect).problem;
}

/// Tries every smaller recipe of many seeds and names the first that fails.
void run(const Recipe& largest, int seeds, const test::Expect& expect) {
  Sums sums;
  for (int s = 1; s <= seeds; ++s) {
    Recipe recipe = largest;
    recipe.seed = std::uint64_t(s);
    const std::string problem = problem_of(recipe, expect, &sums);
    if (problem.empty())
      continue;
    for (int levels = 1; levels <= largest.levels; ++levels)
      for (int roots = 1; roots <= largest.roots; ++roots)
        for (int t = 1; t <= 4 * seeds; ++t) {
          const Recipe smaller{std::uint64_t(t), largest.kind, roots, levels};
          const std::string again = problem_of(smaller, expect);
          ASSERT_EQ(again, "") << smaller.name() << ", a smaller one than " << recipe.name();
        }
    FAIL() << problem << ": " << recipe.name();
  }
  testing::Test::RecordProperty("stitching", int(sums.stitching));
  testing::Test::RecordProperty("folded", int(sums.folded));
  testing::Test::RecordProperty("repaired", int(sums.repaired));
  std::printf("kind %d: %lld meshes, %lld stitching cells, %lld folded, %lld virtual leaves, %lld "
              "folded after the repair\n",
              largest.kind, (long long)sums.meshes, (long long)sums.stitching,
              (long long)sums.folded, (long long)sums.repaired, (long long)sums.still);
}

} // namespace

TEST(RandomDual, LevelDifferencesOfOneDoNotFold) {
  run({1, 0, 3, 2}, 20, {});
  run({1, 1, 3, 2}, 20, {});
}

TEST(RandomDual, ReentrantDomains) {
  for (int levels = 1; levels <= 3; ++levels) {
    run({1, 3, 3, levels}, 25, {});
    run({1, 4, 2, levels}, 25, {});
  }
  run({1, 3, 2, 5}, 15, {});
}

TEST(RandomDual, LeavesLeftOut) {
  run({1, 6, 3, 1}, 25, {});
  for (int levels = 2; levels <= 4; ++levels)
    run({1, 6, 2, levels}, 25, {.conforming = false});
}

TEST(RandomDual, Octrees) {
  run({1, 0, 2, 4}, 40, {});
  run({1, 0, 2, 5}, 15, {});
}

TEST(RandomDual, LevelDifferencesUpToSix) {
  run({1, 5, 1, 7}, 20, {});
  run({1, 5, 2, 7}, 10, {});
}

TEST(RandomDual, Patches) {
  run({1, 1, 2, 3}, 25, {});
  run({1, 2, 2, 3}, 10, {});
}

/// Ghost cells around every patch, or every leaf: linear fields are met up to the boundary, at
/// holes and re-entrant corners too, in domains that are one leaf wide, and where leaves are split.
TEST(RandomDual, GhostCellsBeyondTheDomain) {
  const test::Expect ghosts{.ghosts = true};
  run({1, 0, 2, 4}, 20, ghosts);
  run({1, 1, 2, 3}, 25, ghosts);
  run({1, 2, 2, 3}, 10, ghosts);
  for (int levels = 1; levels <= 3; ++levels) {
    run({1, 3, 3, levels}, 15, ghosts);
    run({1, 4, 2, levels}, 15, ghosts);
  }
  run({1, 5, 2, 7}, 10, ghosts);
  run({1, 6, 3, 1}, 25, ghosts);
}
