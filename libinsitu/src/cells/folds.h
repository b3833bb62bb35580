#pragma once

#include "math/vec.h"
#include "mesh/shape.h"

namespace insitu::cells {

/// Whether the Jacobian of a cell's map takes both signs anywhere in the closed cell. False is
/// proven, beyond rounding at the cell's scale: the determinant's Bernstein coefficients,
/// subdivided where they do not tell, keep one sign or zero (collapsed edges, where it vanishes,
/// are no folds). True is proven, too, but for determinants that come within about 1e-3 of the
/// cell's mean of changing sign inside it.
/// The coefficients are jacobian_signs.inl's.
bool jacobian_changes_sign(mesh::Shape shape, const math::Vec3d* x);

} // namespace insitu::cells
