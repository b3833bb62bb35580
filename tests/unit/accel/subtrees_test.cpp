// The parts that passes from the bottom up go through.
#include <atomic>
#include <gtest/gtest.h>

#include "accel/tree/subtrees.h"
#include "fixtures/committed.h"

using namespace insitu;
using accel::Builder;

namespace {

/// Every node comes once, after all below it; and parts are the same for any number of threads.
void expect_bottom_up(const accel::Tree& tree) {
  const accel::Subtrees subtrees(tree.nodes(), tree.levels());
  EXPECT_EQ(subtrees.parts() > 1, tree.node_count() > 1024); // what fits a cache is not cut
  std::vector<std::size_t> expected;
  for (const int count : {1, 2}) {
    const core::Threads threads(count);
    std::vector<std::atomic<int>> visits(tree.node_count());
    std::vector<std::size_t> part_of(tree.node_count());
    std::atomic<int> early{0};
    subtrees.bottom_up(threads, [&](std::size_t part, std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t i = begin; i < end; ++i) {
        const accel::Node& node = tree.nodes()[i];
        for (int c = 0; c < 8; ++c)
          if (node.is_inner(c) && visits[node.child_node(c)] != 1)
            ++early;
        ++visits[i];
        part_of[i] = part;
      }
    });
    EXPECT_EQ(early, 0);
    for (std::uint32_t i = 0; i < tree.node_count(); ++i) {
      ASSERT_EQ(visits[i], 1) << "node " << i;
      ASSERT_LT(part_of[i], subtrees.parts());
    }
    if (expected.empty())
      expected = part_of;
    EXPECT_EQ(part_of, expected);
  }
}

} // namespace

TEST(Subtrees, CoverTreesOfAnySizeFromTheBottomUp) {
  for (const int size : {1, 2, 9, 30}) // up to 27000 cells: several parts
    for (const Builder builder : {Builder::morton, Builder::surface_area}) {
      fixtures::Committed m(test::make_mesh({.kind = test::MeshKind::hexahedra, .size = size}, 43),
                            1, builder);
      expect_bottom_up(m.mesh.tree());
    }
}

TEST(Subtrees, CoverUnevenTrees) {
  // Half of the cells in one place: one branch is deep, its nodes are full.
  test::TestMesh mesh = test::make_mesh({.kind = test::MeshKind::hexahedra, .size = 16}, 44);
  mesh.cells.resize(mesh.cells.size() + 20000, mesh.cells[77]);
  fixtures::Committed m(mesh, 1, Builder::morton);
  expect_bottom_up(m.mesh.tree());
}
