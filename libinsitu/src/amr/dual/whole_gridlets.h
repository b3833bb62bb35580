#pragma once

#include <vector>

#include "amr/dual/enumerate.h"
#include "amr/dual/shared_leaves.h"

namespace insitu::amr {

/// Collective: parts of a gridlet that seams cut become as large as the gridlet that one process
/// would make of them, with the same cells full as before, since places in a gridlet are counted
/// from its lower corner. 20 bytes a gridlet there and back.
/// made: no vertices are at the leaves that these split.
void make_gridlets_whole(std::vector<DualPart>& parts, const BrickStore& store,
                         const VirtualLeaves& made, const SharedLeaves& shared);

} // namespace insitu::amr
