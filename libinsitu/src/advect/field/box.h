#pragma once

#include <algorithm>
#include <limits>

#include "mesh/box.h"

namespace insitu::advect {

using mesh::Box;
using mesh::box_of;

/// The lengths of a box's edges, as sizes of steps are measured in them: one far shorter than the
/// others counts as 1e-6 of the longest.
inline math::Vec3d edges_of(const Box& box) {
  math::Vec3d e = box.size();
  const double least =
      std::max(1e-6 * std::max({e.x, e.y, e.z}), std::numeric_limits<double>::min());
  for (int a = 0; a < 3; ++a)
    e[a] = std::max(e[a], least);
  return e;
}

} // namespace insitu::advect
