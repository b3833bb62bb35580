#pragma once

#include <cstdint>
#include <vector>

#include "mesh/adaptive.h"

namespace insitu::amr {

/// Leaves that only the dual mesh has.
struct VirtualLeaves {
  struct Leaf {
    mesh::AmrCell cell;
    mesh::AmrCell real; ///< the leaf that it lies in
    std::uint32_t real_id;
  };
  std::int64_t first = 0;           ///< the first one's id; the others follow
  std::vector<Leaf> leaves;         ///< those that lie in one real leaf: not together
  std::vector<mesh::AmrCell> split; ///< cells that were split, coarse ones first
};

} // namespace insitu::amr
