#pragma once

#include <vector>

#include "amr/dual/enumerate.h"
#include "amr/dual/shared_leaves.h"
#include "amr/dual/virtual_leaves.h"

namespace insitu::amr {

/// Splits coarse leaves, for the dual mesh alone, until depths differ by one at most around the
/// given corners and around all corners of the leaves that this makes: the 2:1 balance of octrees
/// over faces, edges and corners, where it is needed. Where depths differ by one at most, no dual
/// cell folds. Collective where leaves are shared: what a split asks of another process's leaf is
/// split there, until nobody asks for more; then all know the splits of all their leaves.
VirtualLeaves balance(const BrickStore& store, const std::vector<SteepCorner>& corners,
                      std::int64_t first_id, const SharedLeaves* shared = nullptr);

/// A copy of a map in which the virtual leaves take the places of those that they split.
void overlay(const BrickStore& store, const VirtualLeaves& leaves, BrickStore& copy,
             const core::Threads& threads);

} // namespace insitu::amr
