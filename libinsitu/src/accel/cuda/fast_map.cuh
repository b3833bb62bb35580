#pragma once

#include "accel/cuda/answer.cuh"
#include "accel/cuda/fast_cell.h"

namespace insitu::accel::cuda {

/// The point's coordinates in a gathered cell, in float, relative to the point.
template <Shape S>
__device__ inline FastMap fast_map(const Gathered<S>& cell, const Vec3d& p) {
  math::Vec3f x[Gathered<S>::count];
#pragma unroll
  for (int v = 0; v < Gathered<S>::count; ++v) {
    const Vec3d d = cell.x[v] - p;
    x[v] = {float(d.x), float(d.y), float(d.z)};
  }
  return fast_inverse(S, x);
}

} // namespace insitu::accel::cuda
