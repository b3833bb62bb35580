#pragma once

#include <bit>
#include <cstdint>

#include "accel/camera_rays/ray_boxes.h"
#include "accel/tree/tree.h"

namespace insitu::accel {

/// Visits the cells whose boxes meet the ray origin + t direction for t in [t_min, t_max], nearer
/// children first (boxes overlap, so the order of cells is only roughly front to back).
///   accept: unsigned(uint32_t node), bit c: child c may hold what is looked for (value ranges);
///   children that are none do not count;
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
    std::uint32_t node;  ///< or the first of the leaf's cells
    std::uint32_t count; ///< 0: a node; otherwise cells
  };
  constexpr int most_depth = 64;
  Entry stack[most_depth * 8];
  int size = 0;
  stack[size++] = {t_min, 0, 0};
  const BoxRay ray(origin, direction, tree.origin());
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
    const unsigned accepted = accept(entry.node) & node.children();
    if (!accepted)
      continue;
    double near[8];
    unsigned met = children_along_ray(node, accepted, ray, t_min, t_max, near);
    // Farthest first, so that the nearest is popped first; insertion sort, stable.
    Entry* const found = stack + size;
    for (int n = 0; met; met &= met - 1, ++n, ++size) {
      const int c = std::countr_zero(met);
      int at = n;
      for (; at > 0 && found[at - 1].t < near[c]; --at)
        found[at] = found[at - 1];
      found[at] = node.is_inner(c) ? Entry{near[c], node.child_node(c), 0}
                                   : Entry{near[c], node.child_cells(c),
                                           std::uint32_t(node.child_cell_count(c))};
    }
  }
}

} // namespace insitu::accel
