#pragma once

#include <cstdint>

#include "accel/camera_rays/child_boxes.h"
#include "accel/camera_rays/nearest_first.h"

namespace insitu::accel {

/// Visits the cells whose boxes meet the ray origin + t direction for t in [t_min, t_max], nearer
/// children first.
///   accept: unsigned(uint32_t node), bit c: child c may hold what is looked for (value ranges);
///   children that are none do not count;
///   visit: double(int64_t flat_cell), tests the cell and returns the new t_max.
/// Boxes are widened by the rounding of the slab test, so no cell is lost to it.
template <class Accept, class Visit>
void for_each_cell_along_ray(const Tree& tree, const math::Vec3d& origin,
                             const math::Vec3d& direction, double t_min, double t_max,
                             Accept&& accept, Visit&& visit) {
  const BoxRay ray(origin, direction, tree.origin());
  visit_nearest_first(
      tree, t_min, t_max,
      [&](const Node& node, std::uint32_t index, double near[8], double last) {
        const unsigned accepted = accept(index) & node.children();
        return accepted ? children_along_ray(node, accepted, ray, t_min, last, near) : 0;
      },
      visit);
}

} // namespace insitu::accel
