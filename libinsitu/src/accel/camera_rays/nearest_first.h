#pragma once

#include <bit>
#include <cstdint>

#include "accel/tree/tree.h"

namespace insitu::accel {

/// Visits cells of a tree, nearer children first (boxes overlap, so the order of cells is only
/// roughly front to back).
///   children: unsigned(const Node&, uint32_t node, double near[8], double last), bit c: child c is
///   wanted, and begins at near[c], a distance or depth that is not behind `last`;
///   visit: double(int64_t flat_cell), takes the cell and returns the new `last`, behind which
///   nothing counts any more.
template <class Children, class Visit>
void visit_nearest_first(const Tree& tree, double first, double last, Children&& children,
                         Visit&& visit) {
  if (tree.empty())
    return;
  struct Entry {
    double near;
    std::uint32_t node;  ///< or the first of the leaf's cells
    std::uint32_t count; ///< 0: a node; otherwise cells
  };
  constexpr int most_depth = 64;
  Entry stack[most_depth * 8];
  int size = 0;
  stack[size++] = {first, 0, 0};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.near > last)
      continue;
    if (entry.count) {
      for (std::uint32_t k = 0; k < entry.count; ++k)
        last = visit(std::int64_t(tree.cells()[entry.node + k]));
      continue;
    }
    const Node& node = tree.nodes()[entry.node];
    double near[8];
    unsigned wanted = children(node, entry.node, near, last);
    // Farthest first, so that the nearest is popped first; insertion sort, stable.
    Entry* const found = stack + size;
    for (int n = 0; wanted; wanted &= wanted - 1, ++n, ++size) {
      const int c = std::countr_zero(wanted);
      int at = n;
      for (; at > 0 && found[at - 1].near < near[c]; --at)
        found[at] = found[at - 1];
      found[at] = node.is_inner(c) ? Entry{near[c], node.child_node(c), 0}
                                   : Entry{near[c], node.child_cells(c),
                                           std::uint32_t(node.child_cell_count(c))};
    }
  }
}

} // namespace insitu::accel
