#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "workload/amr.h"

namespace insitu::workload {
namespace {

using Cell = std::array<std::int32_t, 3>;

/// Level of the leaf at each cell of the finest level.
struct Finest {
  explicit Finest(const Octree& octree)
      : n(int(std::lround(256.0 / octree.spacing)) << (octree.level_count - 1)),
        levels(std::size_t(n) * n * n, -1) {
    const AmrLeaves& leaves = octree.leaves;
    for (std::size_t i = 0; i < leaves.levels.size(); ++i) {
      const int width = 1 << (octree.level_count - 1 - leaves.levels[i]);
      const std::int32_t* at = &leaves.corners[3 * i];
      for (int z = at[2] * width; z < (at[2] + 1) * width; ++z)
        for (int y = at[1] * width; y < (at[1] + 1) * width; ++y)
          for (int x = at[0] * width; x < (at[0] + 1) * width; ++x) {
            overlapping += level(x, y, z) >= 0;
            level(x, y, z) = leaves.levels[i];
          }
    }
  }
  int& level(int x, int y, int z) { return levels[(std::size_t(z) * n + y) * n + x]; }

  /// The largest difference of levels across faces, edges and corners.
  int jump() {
    int out = 0;
    for (int z = 0; z < n; ++z)
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
          for (int k = 0; k < 27; ++k) {
            const Cell at = {x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1};
            if (std::all_of(at.begin(), at.end(), [&](int i) { return i >= 0 && i < n; }))
              out = std::max(out, level(x, y, z) - level(at[0], at[1], at[2]));
          }
    return out;
  }

  int n;
  std::vector<int> levels;
  std::int64_t overlapping = 0;
};

TEST(OctreeWorkload, BalancedOctreesSplitLeavesUntilLevelsDifferByOne) {
  for (const double reach : {0.5, 1.0}) {
    const Octree octree = make_octree(reach, 5), balanced = workload::balanced(octree);
    Finest before(octree), after(balanced);
    ASSERT_GT(before.jump(), 1) << "reach " << reach; // there's something to do
    EXPECT_EQ(after.jump(), 1);
    EXPECT_EQ(after.overlapping, 0);
    EXPECT_EQ(std::count(after.levels.begin(), after.levels.end(), -1), 0);
    EXPECT_EQ(balanced.level_count, octree.level_count);
    EXPECT_EQ(balanced.reach, octree.reach);
    // Leaves are split, never joined, and only where another leaf asks for it: balancing again
    // changes nothing.
    for (std::size_t i = 0; i < before.levels.size(); ++i)
      ASSERT_GE(after.levels[i], before.levels[i]) << i;
    const Octree again = workload::balanced(balanced);
    EXPECT_EQ(again.leaves.levels, balanced.leaves.levels);
    EXPECT_EQ(again.leaves.corners, balanced.leaves.corners);
    EXPECT_EQ(again.leaves.values, balanced.leaves.values);
  }
}

TEST(OctreeWorkload, NoLeafOfABalancedOctreeIsSplitWithoutNeed) {
  // One leaf of level 3 in a corner: each level's cells about it are split once, no others.
  Octree octree = make_octree(0.0, 1);
  ASSERT_EQ(octree.leaves.levels.size(), 64u);
  octree.level_count = 4;
  AmrLeaves& leaves = octree.leaves;
  Cell at = {0, 0, 0};
  leaves.levels.erase(leaves.levels.begin());
  leaves.corners.erase(leaves.corners.begin(), leaves.corners.begin() + 3);
  leaves.values.erase(leaves.values.begin());
  for (int level = 1; level < 4; ++level)
    for (int child = level == 3 ? 0 : 1; child < 8; ++child) {
      at = {child & 1, child >> 1 & 1, child >> 2};
      leaves.levels.push_back(level);
      leaves.corners.insert(leaves.corners.end(), at.begin(), at.end());
      leaves.values.push_back(0.0);
    }
  std::map<int, int> counts;
  for (const std::int32_t level : balanced(octree).leaves.levels)
    ++counts[level];
  EXPECT_EQ(counts, (std::map<int, int>{{0, 63}, {1, 7}, {2, 7}, {3, 8}})); // balanced already

  // The same with its fine leaf at the far end of its cell: 7 more cells of level 0 are split,
  // and all of level 1 about that corner.
  for (std::size_t i = 0; i < leaves.levels.size(); ++i)
    if (leaves.levels[i] > 0)
      for (std::size_t a = 0; a < 3; ++a)
        leaves.corners[3 * i + a] = (1 << leaves.levels[i]) - 1 - leaves.corners[3 * i + a];
  counts.clear();
  const Octree out = balanced(octree);
  for (const std::int32_t level : out.leaves.levels)
    ++counts[level];
  EXPECT_EQ(Finest(out).jump(), 1);
  EXPECT_EQ(counts, (std::map<int, int>{{0, 56}, {1, 7 + 7 * 8 - 7}, {2, 7 + 7 * 8}, {3, 8}}));
}

TEST(OctreeWorkload, FrontsAreRefinedWithABufferAndBalanced) {
  for (const int roots : {8, 11}) {
    const Octree octree = make_front_octree(roots, 4);
    Finest finest(octree);
    EXPECT_EQ(finest.jump(), 1) << roots;
    EXPECT_EQ(finest.overlapping, 0);
    EXPECT_EQ(std::count(finest.levels.begin(), finest.levels.end(), -1), 0);
    EXPECT_EQ(finest.level(0, 0, 0), 0); // coarse far from the front
    // Two cells of the finest level's parents on both sides of the front, along an axis.
    const int middle = finest.n / 2;
    const double width = 256.0 / finest.n;
    for (int x = 0; x < finest.n; ++x) {
      const double distance = std::fabs(std::fabs((x + 0.5) * width - 128.0) - 85.0);
      if (distance < 2 * 2 * width) {
        EXPECT_EQ(finest.level(x, middle, middle), 3) << x;
      }
    }
  }
  const Octree sized = make_front_octree(std::int64_t(20'000));
  EXPECT_NEAR(double(sized.leaves.levels.size()) / 20'000, 1.0, 0.5);
}

} // namespace
} // namespace insitu::workload
