#pragma once

#include <cmath>
#include <cstdint>

#include "mesh/gridlet.h"

namespace insitu::accel {

/// The stretch of a ray between two planes across an axis, widened by the rounding of its bounds.
struct RayStretch {
  double from, to;

  /// A stretch cut to low <= x[axis] <= high; empty (from > to) if it never is.
  RayStretch between(double origin, double direction, double low, double high) const {
    const double slack = (std::fabs(low) + std::fabs(high) + std::fabs(origin)) * 0x1p-48;
    low -= slack;
    high += slack;
    RayStretch cut = *this;
    if (direction == 0.0) {
      if (origin < low || origin > high)
        cut.to = cut.from - 1.0;
      return cut;
    }
    const double near = ((direction > 0.0 ? low : high) - origin) / direction;
    const double far = ((direction > 0.0 ? high : low) - origin) / direction;
    cut.from = std::fmax(from, near - std::fabs(near) * 0x1p-50);
    cut.to = std::fmin(to, far + std::fabs(far) * 0x1p-50);
    return cut;
  }
  bool is_empty() const { return !(from <= to); }
};

/// Visits the full cells of a gridlet that a ray may meet for t in [t_min, t_max], a few more, in
/// no order that matters: visit(local), numbered as in Gridlet.
template <class Visit>
void for_each_cell_along_ray(const mesh::GridletsView& all, std::int64_t gridlet,
                             const math::Vec3d& origin, const math::Vec3d& direction, double t_min,
                             double t_max, Visit&& visit) {
  const mesh::Gridlet& g = all.gridlets[gridlet];
  const auto cut = [&](const RayStretch& stretch, int axis, int i) {
    return stretch.between(origin[axis], direction[axis], all.coordinate(g, axis, i),
                           all.coordinate(g, axis, i + 1));
  };
  const std::int64_t first = gridlet << mesh::Gridlet::cell_bits;
  for (int k = 0; k < g.size[2]; ++k) {
    const RayStretch layer = cut({t_min, t_max}, 2, k);
    if (layer.is_empty())
      continue;
    for (int j = 0; j < g.size[1]; ++j) {
      const RayStretch row = cut(layer, 1, j);
      if (row.is_empty())
        continue;
      for (int i = 0; i < g.size[0]; ++i) {
        const int local = i + 8 * (j + 8 * k);
        if (all.is_full(first + local) && !cut(row, 0, i).is_empty())
          visit(local);
      }
    }
  }
}

} // namespace insitu::accel
