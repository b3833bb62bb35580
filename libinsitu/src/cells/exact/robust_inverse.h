#pragma once

#include "math/vec.h"
#include "mesh/shape.h"

namespace insitu::cells {

/// Parametric coordinates, within the reference cell, of a point that is known to lie in the closed
/// cell, for cells on which Newton's method stalls (collapsed edges, strong twist): damped
/// least squares from several starts, the best answer kept. Slow; always returns.
math::Vec3d robust_inverse(mesh::Shape shape, const math::Vec3d* x, const math::Vec3d& p);

} // namespace insitu::cells
