#pragma once

#include <cstdint>

#include "cells/kernels/cell_block.h"

namespace insitu::cells {

/// Whether the Jacobian of a cell's map takes both signs anywhere in the closed cell. False is
/// proven, beyond rounding at the cell's scale: the determinant's Bernstein coefficients,
/// subdivided where they do not tell, keep one sign or zero (collapsed edges, where it vanishes,
/// are no folds). True is proven, too, but for determinants that come within about 1e-3 of the
/// cell's mean of changing sign inside it.
/// The coefficients are jacobian_signs.inl's.
bool jacobian_changes_sign(mesh::Shape shape, const math::Vec3d* x);

/// What the geometry of a block's cells shows, a bit a cell.
struct CellKinds {
  std::uint64_t folded = 0;
  std::uint64_t inverted = 0;  ///< the other way round than VTK's rule, and not folded
  std::uint64_t flat = 0;      ///< without volume
  std::uint64_t collapsed = 0; ///< two vertices coincide
};

/// Coordinates must be finite.
CellKinds kinds_of(mesh::Shape shape, CellBlock& block);

} // namespace insitu::cells
