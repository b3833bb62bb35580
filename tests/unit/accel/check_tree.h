#pragma once

#include <gtest/gtest.h>
#include <vector>

#include "accel/tree/tree.h"

namespace insitu::accel {

inline void expect_holds(const Tree& tree, const Box& b, const math::Vec3d& p, std::int64_t cell) {
  for (int a = 0; a < 3; ++a) {
    const double local = p[a] - tree.origin()[a];
    ASSERT_LE(double(b.lower[a]), local) << "cell " << cell;
    ASSERT_GE(double(b.upper[a]), local) << "cell " << cell;
  }
}

/// Every cell that owns points lies in one leaf, within the boxes of all its ancestors; levels are
/// ranges in order.
inline void check_tree(const Tree& tree, const mesh::MeshView& view) {
  std::vector<int> seen(std::size_t(view.cell_count()), 0);
  const std::vector<std::uint32_t>& levels = tree.levels();
  ASSERT_GE(levels.size(), tree.empty() ? 0u : 2u);
  if (!tree.empty()) {
    ASSERT_EQ(levels.front(), 0u);
    ASSERT_EQ(levels[1], 1u);
    ASSERT_EQ(levels.back(), tree.node_count());
  }
  std::vector<int> parents(tree.node_count(), 0);
  std::vector<std::vector<Box>> ancestors(tree.node_count()); // of the nodes of the next level
  for (std::size_t l = 0; l + 1 < levels.size(); ++l)
    for (std::uint32_t n = levels[l]; n < levels[l + 1]; ++n) {
      const Node& node = tree.nodes()[n];
      int children = 0;
      for (int c = 0; c < 8; ++c) {
        if (!node.meta[c])
          continue;
        ++children;
        std::vector<Box> above = ancestors[n];
        above.push_back(node.child_box(c));
        if (node.is_inner(c)) {
          const std::uint32_t child = node.child_node(c);
          ASSERT_GE(child, levels[l + 1]);
          ASSERT_LT(child, levels[l + 2]);
          ++parents[child];
          ancestors[child] = above;
          continue;
        }
        ASSERT_GE(node.child_cell_count(c), 1);
        ASSERT_LE(node.child_cell_count(c), accel::most_leaf_cells);
        for (int k = 0; k < node.child_cell_count(c); ++k) {
          const std::int64_t flat = tree.cells()[node.child_cells(c) + std::uint32_t(k)];
          ASSERT_LT(flat, view.cell_count());
          ++seen[std::size_t(flat)];
          mesh::CellVertices cell;
          mesh::gather(view, flat, cell);
          for (int v = 0; v < cell.count; ++v) {
            for (const Box& b : above)
              expect_holds(tree, b, cell.x[v], flat);
            for (int a = 0; a < 3; ++a) {
              ASSERT_GE(cell.x[v][a], tree.bounds_min()[a]);
              ASSERT_LE(cell.x[v][a], tree.bounds_max()[a]);
            }
          }
        }
      }
      ASSERT_GE(children, 1);
    }
  for (std::uint32_t n = 1; n < tree.node_count(); ++n)
    ASSERT_EQ(parents[n], 1);
  for (std::size_t c = 0; c < seen.size(); ++c) {
    const std::int32_t p = view.piece_of(std::int64_t(c));
    ASSERT_EQ(seen[c], view.pieces[p].owns(std::int64_t(c) - view.first_cell[p]) ? 1 : 0)
        << "cell " << c;
  }
}

} // namespace insitu::accel
