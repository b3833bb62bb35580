#pragma once

#include <cstdint>
#include <limits>

#include "accel/camera_rays/child_boxes.h"
#include "accel/camera_rays/nearest_first.h"

namespace insitu::accel {

/// Visits the cells whose boxes may reach into a frustum, nearer children first.
///   accept: unsigned(uint32_t node), bit c: child c may hold what is looked for (value ranges);
///   children that do not exist do not count;
///   visit: double(int64_t flat_cell), takes the cell and returns the depth behind which nothing
///   counts any more.
template <class Accept, class Visit>
void for_each_cell_in_frustum(const Tree& tree, const Frustum& frustum, Accept&& accept,
                              Visit&& visit) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const BoxFrustum local(frustum, tree.origin());
  visit_nearest_first(
      tree, -infinity, infinity,
      [&](const Node& node, std::uint32_t index, double depth[8], double) {
        const unsigned accepted = accept(index) & node.children();
        return accepted ? children_in_frustum(node, accepted, local, depth) : 0;
      },
      visit);
}

} // namespace insitu::accel
