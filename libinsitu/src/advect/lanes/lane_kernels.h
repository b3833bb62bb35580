#pragma once

#include "advect/integrate/settings.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// What LaneBatch does with SIMD; compiled per target and dispatched at run time.
namespace insitu::advect {

/// A point and the cell that may hold it, with the velocities at the cell's vertices. Of both there
/// is room for eight, whatever the shape: all may be read.
struct LaneQuery {
  math::Vec3d point;
  const math::Vec3d* vertices;
  const math::Vec3d (*velocity)[8]; ///< [step][vertex], or null: not interpolated
  double weights[most_steps];       ///< [step]; one step has none
};

struct LaneAnswer {
  math::Vec3d r;
  double margin, error; ///< see cells::InverseMap
  bool converged;
  math::Vec3d velocity;
};

/// Inverts the maps of n cells of one shape, and interpolates. The same bits as cells::inverse_map
/// and sums of cells::shape_functions times velocities, those of further steps added in their
/// order. All queries have velocities, of `steps` steps, or none.
void invert_lanes(mesh::Shape shape, const LaneQuery* queries, int n, int steps,
                  LaneAnswer* answers);

} // namespace insitu::advect
