#pragma once

#include <algorithm>
#include <limits>

#include "math/vec.h"
#include "mesh/view.h"

namespace insitu::advect {

/// An axis-aligned box.
struct Box {
  math::Vec3d low, high;

  bool holds(const math::Vec3d& x) const {
    return x.x >= low.x && x.y >= low.y && x.z >= low.z && x.x <= high.x && x.y <= high.y &&
           x.z <= high.z;
  }
  math::Vec3d middle() const { return 0.5 * (low + high); }
  /// The lengths of the edges. One far shorter than the others counts as 1e-6 of the longest: sizes
  /// of steps are measured in it.
  math::Vec3d extent() const {
    math::Vec3d e = high - low;
    const double least =
        std::max(1e-6 * std::max({e.x, e.y, e.z}), std::numeric_limits<double>::min());
    for (int a = 0; a < 3; ++a)
      e[a] = std::max(e[a], least);
    return e;
  }
};

inline Box box_of(const mesh::CellVertices& c) {
  Box box{c.x[0], c.x[0]};
  for (int i = 1; i < c.count; ++i)
    for (int a = 0; a < 3; ++a) {
      box.low[a] = std::min(box.low[a], c.x[i][a]);
      box.high[a] = std::max(box.high[a], c.x[i][a]);
    }
  return box;
}

} // namespace insitu::advect
