#pragma once

#include <span>
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

/// The dual mesh of some bricks. Leaves with ids from `real` on are virtual: they lie
/// in stitching cells only.
void enumerate(const BrickStore& store, std::span<const std::uint32_t> bricks, std::int64_t real,
               Check check, DualPart& part);

} // namespace insitu::amr
