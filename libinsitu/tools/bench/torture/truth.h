#pragma once

#include "cells/exact/contain_exact.h"
#include "torture/points.h"

namespace insitu::bench::torture {

/// Who owns points, by exact arithmetic and without any tree: every cell is asked.
struct Truth {
  std::vector<std::int64_t> owners;      ///< the lowest id of the cells that hold the point, or -1
  std::vector<cells::Containment> where; ///< the point in its owner
  std::int64_t owned = 0;
  std::int64_t gaps = 0;     ///< points within the hull that no cell holds
  std::int64_t overlaps = 0; ///< points strictly inside several cells
};
Truth find_owners(const workload::Mesh& mesh, const std::vector<Point>& points);

/// The distance from p to where its parametric coordinates in a cell map, over the cell's diameter.
double mapped_error(const workload::Mesh& mesh, std::int64_t cell, const math::Vec3d& parametric,
                    const math::Vec3d& p);

} // namespace insitu::bench::torture
