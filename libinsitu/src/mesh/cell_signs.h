#pragma once

#include <cstdint>

#include "mesh/shape.h"

/// What validation asks of every cell's geometry, for blocks of cells, compiled per SIMD target and
/// dispatched at run time.
namespace insitu::mesh {

/// At most 64 cells of one shape, transposed. Rows are a cache line longer than they need be, so
/// that a cell's numbers do not fall into few sets of the cache.
struct CellBlock {
  static constexpr int size = 64;
  int count = 0;
  alignas(64) double vertex[8][3][size + 8];
};

/// One bit per cell. Volumes are those of the corners' tripods, right-handed in a cell that is the
/// right way round by VTK's rule (face normals outwards; a wedge's triangle 0 1 2 faces away from 3
/// 4 5), and zero to rounding is neither sign.
struct CellSigns {
  std::uint64_t positive = 0, negative = 0; ///< some corner's volume is
  std::uint64_t coincident = 0;             ///< two vertices coincide
  /// The Jacobian is not proven to keep its sign throughout the cell by its Bernstein coefficients:
  /// jacobian_changes_sign (folds.h) decides.
  std::uint64_t unsure = 0;
};

/// Coordinates must be finite.
CellSigns cell_signs(Shape shape, CellBlock& block);

} // namespace insitu::mesh
