#pragma once

#include <vector>

#include "amr/enumerate.h"
#include "amr/virtual_leaves.h"

namespace insitu::amr {

/// Splits coarse leaves, for the dual mesh alone, until depths differ by one at most around every
/// corner: the 2:1 balance of octrees over faces, edges and corners. Given are the corners around
/// which they differ by more. Where they differ by one at most, dual cells do not fold.
VirtualLeaves balance(const BrickStore& store, const std::vector<DualPart>& parts,
                      std::int64_t first_id);

/// A copy of a map in which the virtual leaves take the places of those that they split.
void overlay(const BrickStore& store, const VirtualLeaves& leaves, BrickStore& copy,
             const core::Threads& threads);

} // namespace insitu::amr
