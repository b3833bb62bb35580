// Random meshes: what must hold for all of them, and the smallest one for which it does not.
#include <gtest/gtest.h>

#include "check_dual.h"

using namespace insitu;
using test::Recipe;

namespace {

struct Sums {
  std::int64_t meshes = 0, stitching = 0, folded = 0, repaired = 0, still = 0;
};

std::string problem_of(const Recipe& recipe, const test::Expect& expect, Sums* sums = nullptr) {
  test::AmrMesh mesh = test::make_mesh(recipe);
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

TEST(RandomDual, Octrees) {
  run({1, 0, 2, 4}, 30, {.no_folds = false});
}

TEST(RandomDual, Patches) {
  run({1, 1, 2, 3}, 20, {.no_folds = false});
  run({1, 2, 2, 3}, 10, {.no_folds = false});
}
