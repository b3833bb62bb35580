#pragma once

#include <span>
#include <vector>

#include "amr/dual/corner_map.h"
#include "amr/dual/dual_cells.h"
#include "amr/dual/reentrant.h"
#include "mesh/gridlet.h"

namespace insitu::amr {

/// A corner around which depths differ by more than one: its cell may fold.
struct SteepCorner {
  SteepCorner(const Corner& corner, bool folds);
  std::int64_t index[3];
  std::int8_t depth;
  std::uint8_t octants = 0; ///< those whose leaf lies two depths above or more
  bool folded;
};

/// What some bricks of a map make of the dual mesh.
struct DualPart {
  std::vector<mesh::Gridlet> gridlets; ///< `first` counts from the part's own
  std::vector<std::uint64_t> full;     ///< 8 words a gridlet
  std::vector<std::uint32_t> leaves;   ///< vertices of gridlets
  std::vector<DualCell> cells;
  std::vector<CornerCell> at_corners; ///< most of them
  std::vector<MeanVertex> means;      ///< vertices of cells
  std::vector<SteepCorner> steep;
  std::int64_t cubes = 0, empty = 0;
  std::int64_t folded = 0; ///< cells
};

/// The dual mesh of some bricks. Leaves with ids from `real` on are virtual: they lie in stitching
/// cells only. Looks for folds where depths differ by more than one and where virtual leaves are.
/// only_unfolded: a part with folds gets no cells and no gridlets, just its steep corners.
void enumerate(const BrickStore& store, const mesh::Lattice& lattice,
               std::span<const std::uint32_t> bricks, std::int64_t real, bool only_unfolded,
               DualPart& part);

} // namespace insitu::amr
