#pragma once

#include <cstdint>
#include <vector>

#include "mesh/adaptive.h"

namespace insitu::amr {

/// The order of cells of a depth: by z, then y, then x.
inline bool comes_before(const std::int64_t* a, const std::int64_t* b) {
  return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

/// Leaves that only the dual mesh has.
struct VirtualLeaves {
  struct Leaf {
    mesh::AmrCell cell;
    mesh::AmrCell real; ///< the leaf that it lies in
    std::uint32_t real_id;
  };
  std::int64_t first = 0; ///< the first one's id; the others follow
  /// In the order of the cells that they are children of, as in `split`, and then of octants.
  std::vector<Leaf> leaves;
  std::vector<mesh::AmrCell> split; ///< cells that were split: by depth, then by comes_before()
};

} // namespace insitu::amr
