#pragma once

#include "math/vec.h"
#include "mesh/shape.h"

/// What LaneBatch does with SIMD; compiled per target and dispatched at run time.
namespace insitu::advect {

/// A point and the cell that may hold it, with the velocities at the cell's vertices.
struct LaneQuery {
  math::Vec3d point;
  const math::Vec3d* vertices;
  const math::Vec3d* velocity; ///< or null: not interpolated
  const math::Vec3d* before;   ///< at the earlier step, or null
  double alpha;                ///< of `velocity`; 1 - alpha of `before`
};

struct LaneAnswer {
  math::Vec3d r;
  double margin, error; ///< see cells::InverseMap
  bool converged;
  math::Vec3d velocity;
};

/// Inverts the maps of n cells of one shape, and interpolates. The same bits as cells::inverse_map
/// and sums of cells::shape_functions times velocities. All queries have velocities, or none; so
/// for those before.
void invert_lanes(mesh::Shape shape, const LaneQuery* queries, int n, LaneAnswer* answers);

} // namespace insitu::advect
