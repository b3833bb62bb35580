#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include "accel/camera_rays/frustum.h"
#include "accel/tree/tree.h"

namespace insitu::accel {

/// Visits the cells whose boxes may reach into a frustum, nearer children first (boxes overlap, so
/// the order of cells is only roughly front to back).
///   accept: unsigned(uint32_t node), bit c: child c may hold what is looked for (value ranges);
///   children that do not exist do not count;
///   visit: double(int64_t flat_cell), takes the cell and returns the depth from which on nothing
///   counts any more.
template <class Accept, class Visit>
void for_each_cell_in_frustum(const Tree& tree, const Frustum& frustum, Accept&& accept,
                              Visit&& visit) {
  if (tree.empty())
    return;
  struct Entry {
    double depth;
    std::uint32_t node;  ///< or the first of the leaf's cells
    std::uint32_t count; ///< 0: a node; otherwise cells
  };
  constexpr int most_depth = 64;
  Entry stack[most_depth * 8];
  int size = 0;
  double farthest = std::numeric_limits<double>::infinity();
  stack[size++] = {-farthest, 0, 0};
  const Frustum local = frustum.from(tree.origin());
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.depth > farthest)
      continue;
    if (entry.count) {
      for (std::uint32_t k = 0; k < entry.count; ++k)
        farthest = visit(std::int64_t(tree.cells()[entry.node + k]));
      continue;
    }
    const Node& node = tree.nodes()[entry.node];
    const unsigned accepted = accept(entry.node) & node.children();
    if (!accepted)
      continue;
    double depth[8];
    unsigned met = children_in_frustum(node, accepted, local, depth);
    // Farthest first, so that the nearest is popped first; insertion sort, stable.
    Entry* const found = stack + size;
    for (int n = 0; met; met &= met - 1, ++n, ++size) {
      const int c = std::countr_zero(met);
      int at = n;
      for (; at > 0 && found[at - 1].depth < depth[c]; --at)
        found[at] = found[at - 1];
      found[at] = node.is_inner(c) ? Entry{depth[c], node.child_node(c), 0}
                                   : Entry{depth[c], node.child_cells(c),
                                           std::uint32_t(node.child_cell_count(c))};
    }
  }
}

} // namespace insitu::accel
