#pragma once

#include <vector>

#include "amr/dual/enumerate.h"
#include "amr/dual/shared_leaves.h"
#include "amr/dual/virtual_leaves.h"

namespace insitu::amr {

/// Splits coarse leaves until the cell of none of a map's steep corners folds;
/// `split` becomes the map with these splits. Collective where leaves are shared: all take the same
/// rounds, in which each looks at the corners that count here.
VirtualLeaves unfold(const BrickStore& store, const mesh::Lattice& lattice,
                     std::vector<SteepCorner> steep, std::int64_t real, BrickStore& split,
                     const core::Threads& threads, const SharedLeaves* shared = nullptr);

/// The bricks whose dual cells these splits change: those with leaves that
/// touch a cell that was split. A flag a brick.
std::vector<char> changed_bricks(const BrickStore& store, const std::vector<mesh::AmrCell>& split);

} // namespace insitu::amr
