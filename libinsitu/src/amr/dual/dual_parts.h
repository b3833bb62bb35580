#pragma once

#include <vector>

#include "amr/dual/enumerate.h"
#include "amr/dual/shared_leaves.h"
#include "amr/dual/virtual_leaves.h"

namespace insitu::amr {

/// All cells of a dual mesh, in parts.
struct DualParts {
  std::vector<DualPart> parts;
  VirtualLeaves made;
  std::int64_t folded = 0, still_folded = 0; ///< cells, before and after the repair
};

/// Enumerates the dual mesh of a map of `real` cells. Where depths differ by more than one around a
/// corner its cells may fold: then leaves there are split virtually (unfold.h) and what lies
/// around them is made anew. Parts are in the order of bricks, by depths and keys, whatever was
/// repaired: so cells have the same order whoever makes them. Does not depend on the thread count.
/// Collective where leaves are shared.
DualParts make_dual_parts(const BrickStore& store, const mesh::Lattice& lattice, std::int64_t real,
                          core::Memory& memory, const core::Threads& threads,
                          const SharedLeaves* shared = nullptr);

} // namespace insitu::amr
