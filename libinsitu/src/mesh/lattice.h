#pragma once

#include <bit>
#include <cstdint>

#include "math/hd.h"
#include "math/vec.h"

namespace insitu::mesh {

/// The nested lattices of an adaptive mesh. Cells of depth d are spacing * 2^-d wide; depth 0 is
/// the coarsest level's, and a level of refinement ratio 4 is two depths below the one above it.
/// Cell i of a depth spans [i, i + 1) of its cells along an axis. Of a flat mesh all cells have the
/// index 0 along the third axis, and one thickness there; points lie in a plane within it.
struct Lattice {
  static constexpr int most_depth = 30;
  static constexpr std::int64_t largest_index = std::int64_t(1) << 30; ///< of cells, either sign

  double origin[3] = {0, 0, 0};  ///< lower corner of cell (0, 0, 0) of every depth
  double spacing[3] = {1, 1, 1}; ///< of depth 0; positive
  double plane = 0.0;            ///< of a flat mesh
  std::int64_t is_flat = 0;      ///< 0 or 1, without bytes that nobody sets

  /// 2^-d, exactly.
  INSITU_HD static double power(int d) {
    return std::bit_cast<double>(std::uint64_t(1023 - d) << 52);
  }
  /// How often cells of a depth are halved along an axis.
  INSITU_HD int halvings(int axis, int depth) const {
    return axis == 2 && is_flat != 0 ? 0 : depth;
  }
  INSITU_HD double width(int axis, int depth) const {
    return spacing[axis] * power(halvings(axis, depth));
  }
  INSITU_HD double half_width(int axis, int depth) const {
    return spacing[axis] * power(halvings(axis, depth) + 1);
  }

  /// Where a coordinate of `halves` half cells of a depth lies: even ones are faces, odd ones
  /// centres of cells. Whatever depth a place is counted in, it has the same bits: powers of two
  /// scale exactly.
  INSITU_HD double place(int axis, int depth, std::int64_t halves) const {
    return origin[axis] + half_width(axis, depth) * double(halves);
  }
  INSITU_HD double centre(int axis, int depth, std::int64_t index) const {
    return place(axis, depth, 2 * index + 1);
  }
};

} // namespace insitu::mesh
