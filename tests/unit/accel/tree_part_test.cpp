// Trees over some of another tree's cells.
#include <cstring>
#include <gtest/gtest.h>

#include "check_tree.h"
#include "core/random.h"
#include "fixtures/committed.h"

using namespace insitu;
using accel::Node;
using accel::Tree;

namespace {

std::vector<std::uint64_t> bits_of(const std::vector<bool>& kept) {
  std::vector<std::uint64_t> bits((kept.size() + 63) / 64, 0);
  for (std::size_t i = 0; i < kept.size(); ++i)
    bits[i / 64] |= std::uint64_t(kept[i]) << (i % 64);
  return bits;
}

/// Every kept cell lies in one leaf, within the boxes of all its ancestors, and no other does;
/// levels are ranges in order; nodes lead to two things at least.
void expect_part(const Tree& part, const Tree& whole, const std::vector<bool>& kept,
                 const mesh::MeshView& view) {
  std::vector<int> seen(std::size_t(view.cell_count()), 0);
  struct Visit {
    std::uint32_t node;
    std::vector<accel::Box> above;
  };
  std::vector<Visit> stack;
  if (!part.empty())
    stack.push_back({0, {}});
  const std::vector<std::uint32_t>& levels = part.levels();
  ASSERT_EQ(levels.empty(), part.empty());
  if (!part.empty()) {
    ASSERT_EQ(levels.back(), part.node_count());
  }
  std::uint32_t nodes = 0;
  while (!stack.empty()) {
    const Visit v = stack.back();
    stack.pop_back();
    ++nodes;
    const Node& node = part.nodes()[v.node];
    const std::size_t level = v.above.size();
    ASSERT_GE(v.node, levels[level]);
    ASSERT_LT(v.node, levels[level + 1]);
    int children = 0;
    for (int c = 0; c < 8; ++c) {
      if (!node.meta[c])
        continue;
      ++children;
      std::vector<accel::Box> above = v.above;
      above.push_back(node.child_box(c));
      if (node.is_inner(c)) {
        stack.push_back({node.child_node(c), above});
        continue;
      }
      const std::int64_t flat = part.cells()[node.child_cells(c)];
      ++seen[std::size_t(flat)];
      mesh::CellVertices cell;
      mesh::gather(view, flat, cell);
      for (int i = 0; i < cell.count; ++i) {
        for (const accel::Box& b : above)
          accel::expect_holds(part, b, cell.x[i], flat);
        for (int a = 0; a < 3; ++a) {
          ASSERT_GE(cell.x[i][a], part.bounds_min()[a]);
          ASSERT_LE(cell.x[i][a], part.bounds_max()[a]);
        }
      }
    }
    ASSERT_GE(children, v.node == 0 ? 1 : 2);
  }
  EXPECT_EQ(nodes, part.node_count());
  std::int64_t count = 0;
  for (std::size_t slot = 0; slot < kept.size(); ++slot) {
    ASSERT_EQ(seen[whole.cells()[slot]], kept[slot] ? 1 : 0) << "place " << slot;
    count += kept[slot];
  }
  EXPECT_EQ(part.cell_count(), count);
}

} // namespace

TEST(TreePart, HoldsTheKeptCellsAndNoOther) {
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::tetrahedra})
    for (const int size : {1, 3, 20}) {
      fixtures::Committed m(test::make_mesh({.kind = kind, .size = size}, 45));
      const Tree& whole = m.mesh.tree();
      const mesh::MeshView& view = m.mesh.mesh().view();
      const auto n = std::size_t(whole.cell_count());
      Tree part(m.memory), again(m.memory);
      for (const double share : {0.5, 0.01, 1.0, 0.0, 0.1}) {
        SCOPED_TRACE(std::to_string(n) + " cells, " + std::to_string(share));
        std::vector<bool> kept(n);
        for (std::size_t i = 0; i < n; ++i)
          kept[i] = core::random_unit(3, i, 0) < share;
        const auto bits = bits_of(kept);
        part.take_part(whole, bits, m.threads);
        expect_part(part, whole, kept, view);
        again.take_part(whole, bits, core::Threads(1));
        ASSERT_EQ(again.node_count(), part.node_count());
        if (!part.empty()) {
          EXPECT_EQ(std::memcmp(again.nodes(), part.nodes(), sizeof(Node) * part.node_count()), 0);
        }
      }
      std::vector<bool> one(n, false); // a slab, and a single cell
      one[n / 2] = true;
      part.take_part(whole, bits_of(one), m.threads);
      expect_part(part, whole, one, view);
      for (std::size_t i = 0; i < n; ++i) {
        mesh::CellVertices cell;
        mesh::gather(view, whole.cells()[i], cell);
        one[i] = cell.x[0].x < 0.3 * whole.bounds_max().x + 0.7 * whole.bounds_min().x;
      }
      part.take_part(whole, bits_of(one), m.threads);
      expect_part(part, whole, one, view);
    }
}

TEST(TreePart, OfNothingIsEmpty) {
  core::Memory memory;
  const Tree none(memory);
  Tree part(memory);
  part.take_part(none, {}, core::Threads(1));
  EXPECT_TRUE(part.empty());
  EXPECT_EQ(part.cell_count(), 0);
}
