#pragma once

#include "device/cell.cuh"
#include "query/device/fast_cell.h"

namespace insitu::query::on_device {

/// The point's coordinates in a gathered cell, in float, relative to the point.
template <mesh::Shape S>
INSITU_HD inline FastMap fast_map(const device::Gathered<S>& cell, const math::Vec3d& p) {
  math::Vec3f x[device::Gathered<S>::count];
  INSITU_UNROLL
  for (int v = 0; v < device::Gathered<S>::count; ++v) {
    const math::Vec3d d = cell.x[v] - p;
    x[v] = {float(d.x), float(d.y), float(d.z)};
  }
  return fast_inverse(S, x);
}

} // namespace insitu::query::on_device
