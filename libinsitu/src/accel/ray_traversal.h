#pragma once

#include <cmath>
#include <cstdint>

#include "accel/tree.h"

namespace insitu::accel {

/// Visits the cells whose boxes meet the ray origin + t direction for t in [t_min, t_max], nearer
/// children first (boxes overlap, so the order of cells is only roughly front to back).
///   accept: bool(uint32_t node, int child), false prunes the child (value ranges);
///   visit: double(int64_t flat_cell), tests the cell and returns the new t_max.
/// Boxes are widened by the rounding of the slab test, so no cell is lost to it.
template <class Accept, class Visit>
void for_each_cell_along_ray(const Tree& tree, const math::Vec3d& origin,
                             const math::Vec3d& direction, double t_min, double t_max,
                             Accept&& accept, Visit&& visit) {
  if (tree.empty())
    return;
  struct Entry {
    double t;
    std::uint32_t node; ///< or the first of the leaf's cells
    std::uint32_t count; ///< 0: a node; otherwise cells
  };
  constexpr int most_depth = 64;
  Entry stack[most_depth * 8];
  int size = 0;
  stack[size++] = {t_min, 0, 0};
  const math::Vec3d o = origin - tree.origin();
  double inverse[3], slack[3];
  for (int a = 0; a < 3; ++a) {
    inverse[a] = 1.0 / direction[a]; // may be infinite; see below
    slack[a] = std::fabs(o[a]) * 0x1p-48;
  }
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.t > t_max)
      continue;
    if (entry.count) {
      for (std::uint32_t k = 0; k < entry.count; ++k)
        t_max = visit(std::int64_t(tree.cells()[entry.node + k]));
      continue;
    }
    const Node& node = tree.nodes()[entry.node];
    Entry found[8];
    int n = 0;
    for (int c = 0; c < 8; ++c) {
      if (!node.meta[c])
        continue;
      const Box box = node.child_box(c);
      double near = t_min, far = t_max;
      for (int a = 0; a < 3; ++a) {
        const double lo = double(box.lower[a]) - slack[a] - o[a];
        const double hi = double(box.upper[a]) + slack[a] - o[a];
        if (direction[a] == 0.0) {
          if (lo > 0.0 || hi < 0.0)
            near = far + 1.0;
          continue;
        }
        // By the direction's sign, not by size: 0 times an infinite inverse is NaN, which the
        // comparisons below pass over.
        double t0 = (direction[a] > 0.0 ? lo : hi) * inverse[a];
        double t1 = (direction[a] > 0.0 ? hi : lo) * inverse[a];
        t0 -= std::fabs(t0) * 0x1p-50;
        t1 += std::fabs(t1) * 0x1p-50;
        near = t0 > near ? t0 : near;
        far = t1 < far ? t1 : far;
      }
      if (!(near <= far) || !accept(entry.node, c))
        continue;
      Entry e;
      e.t = near;
      e.count = node.is_inner(c) ? 0u : std::uint32_t(node.child_cell_count(c));
      e.node = node.is_inner(c) ? node.child_node(c) : node.child_cells(c);
      // Farthest first, so that the nearest is popped first; insertion sort, stable.
      int at = n++;
      for (; at > 0 && found[at - 1].t < e.t; --at)
        found[at] = found[at - 1];
      found[at] = e;
    }
    for (int i = 0; i < n; ++i)
      stack[size++] = found[i];
  }
}

} // namespace insitu::accel
