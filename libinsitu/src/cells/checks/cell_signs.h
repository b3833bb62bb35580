#pragma once

#include <cstdint>

#include "cells/kernels/cell_block.h"

namespace insitu::cells {

/// What validation asks of every cell's geometry, one bit per cell of a block. Volumes are those of
/// the corners' tripods, right-handed in a cell that is the right way round by VTK's rule (face
/// normals outwards; a wedge's triangle 0 1 2 faces away from 3 4 5), and zero to rounding is
/// neither sign.
struct CellSigns {
  std::uint64_t positive = 0, negative = 0; ///< some corner's volume is
  std::uint64_t coincident = 0;             ///< two vertices coincide
  /// The Jacobian is not proven to keep its sign throughout the cell by its Bernstein coefficients:
  /// jacobian_changes_sign (folds.h) decides.
  std::uint64_t unsure = 0;
};

/// jacobian_signs for a block, compiled per SIMD target. Coordinates must be finite.
CellSigns cell_signs(mesh::Shape shape, CellBlock& block);

} // namespace insitu::cells
