#pragma once

#include "math/vec.h"
#include "mesh/shape.h"

namespace insitu::mesh {

/// Whether the Jacobian of a cell's map takes both signs anywhere in the closed cell. False is
/// proven, beyond rounding at the cell's scale: the determinant's Bernstein coefficients,
/// subdivided where they do not tell, keep one sign or zero (collapsed edges, where it vanishes,
/// are no folds). True is proven, too, but for determinants that come within about 1e-3 of the
/// cell's mean of changing sign inside it.
///
/// The determinant is constant in a tetrahedron, bilinear in (r, s) in a pyramid (about its apex),
/// linear in (r, s) and quadratic in t in a wedge, and quadratic in each of r, s, t in a
/// hexahedron. After Johnen, Remacle and Geuzaine 2013, "Geometrical validity of curvilinear finite
/// elements".
bool jacobian_changes_sign(Shape shape, const math::Vec3d* x);

} // namespace insitu::mesh
