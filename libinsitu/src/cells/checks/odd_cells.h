#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::cells {

/// The cells that own points and fold, are without volume, or are the other way round than most.
/// Outside of their boxes a point strictly inside a cell's image has one preimage there, and no
/// cell is turned over onto its neighbours.
struct OddCells {
  static constexpr std::int64_t most = 32;
  /// There are not more than `most` of them: `ids` has them all, ascending.
  bool few = false;
  std::vector<std::int64_t> ids;

  bool none() const { return few && ids.empty(); }
};

/// Looks at the geometry alone; the arrays must be known to be valid.
OddCells find_odd_cells(const mesh::MeshView& mesh, const core::Threads& threads);

/// The same for a mesh that was just validated: its counts often tell.
OddCells find_odd_cells(const mesh::MeshView& mesh, const insitu_validation& counts,
                        const core::Threads& threads);

} // namespace insitu::cells
