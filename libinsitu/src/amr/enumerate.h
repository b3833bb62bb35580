#pragma once

#include <vector>

#include "amr/dual_cells.h"
#include "mesh/gridlet.h"

namespace insitu::amr {

/// What some bricks of a map make of the dual mesh.
struct DualPart {
  std::vector<mesh::Gridlet> gridlets; ///< `first` counts from the part's own
  std::vector<std::uint64_t> full;     ///< 8 words a gridlet
  std::vector<std::uint32_t> leaves;   ///< vertices of gridlets
  std::vector<DualCell> cells;
  std::int64_t cubes = 0, empty = 0;
  std::int64_t folded = 0;   ///< of cells around corners where depths differ by more than one
  std::vector<Corner> steep; ///< those corners
};

/// Which corners are looked at for folds.
enum class Check { steep, split }; ///< steep: depths differ by more than one; split: virtual leaves

/// Bricks a part; parts do not depend on the thread count.
constexpr std::int64_t bricks_a_part = 32;

/// The dual mesh of the bricks [begin, end). Leaves with ids from `real` on are virtual: they lie
/// in stitching cells only.
void enumerate(const BrickStore& store, std::int64_t begin, std::int64_t end, std::int64_t real,
               Check check, DualPart& part);

} // namespace insitu::amr
