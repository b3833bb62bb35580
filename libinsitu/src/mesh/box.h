#pragma once

#include <algorithm>

#include "math/vec.h"
#include "mesh/view.h"

namespace insitu::mesh {

/// An axis-aligned box.
struct Box {
  math::Vec3d low, high;

  bool holds(const math::Vec3d& x) const {
    return x.x >= low.x && x.y >= low.y && x.z >= low.z && x.x <= high.x && x.y <= high.y &&
           x.z <= high.z;
  }
  math::Vec3d middle() const { return 0.5 * (low + high); }
  math::Vec3d size() const { return high - low; }
  void extend(const Box& other) {
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], other.low[a]);
      high[a] = std::max(high[a], other.high[a]);
    }
  }
};

/// Whether two closed boxes have a point in common.
inline bool meet(const Box& a, const Box& b) {
  bool yes = true;
  for (int axis = 0; axis < 3; ++axis)
    yes &= a.low[axis] <= b.high[axis] && b.low[axis] <= a.high[axis];
  return yes;
}

/// Of a cell's vertices.
inline Box box_of(const CellVertices& c) {
  Box box{c.x[0], c.x[0]};
  for (int v = 1; v < c.count; ++v)
    box.extend({c.x[v], c.x[v]});
  return box;
}

} // namespace insitu::mesh
