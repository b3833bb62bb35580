#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scaling/cost_model.h"
#include "scaling/layout.h"

namespace insitu::bench::scaling {

/// An octree of two levels on the cells of a box, spread over processes by the same cuts: within a
/// shell around the middle of each box of the size of a weak run's part, cells are split.
struct LeafLayout {
  Layout coarse;

  /// About so many leaves in all; or, weak, on each process.
  LeafLayout(int processes, std::int64_t leaves, bool weak);

  bool is_split(int i, int j, int k) const;
  /// Calls f(level, corner among the level's cells) for the leaves of a process, in their order.
  template <class F>
  void for_leaves(int rank, F&& f) const {
    const Layout::Part part = coarse.part(rank);
    for (int k = part.first[2]; k < part.end[2]; ++k)
      for (int j = part.first[1]; j < part.end[1]; ++j)
        for (int i = part.first[0]; i < part.end[0]; ++i) {
          if (!is_split(i, j, k)) {
            f(0, std::array{i, j, k});
            continue;
          }
          for (int child = 0; child < 8; ++child)
            f(1, std::array{2 * i + (child & 1), 2 * j + (child >> 1 & 1), 2 * k + (child >> 2)});
        }
  }
};

/// The arrays of a process.
struct PartLeaves {
  std::vector<std::int32_t> levels, corners; ///< corners interleaved, each on its level
  std::vector<double> values;                ///< the distance from the box's middle
};
PartLeaves make_leaves(const LeafLayout& layout, int rank);

/// What processes send each other: after a regrid, and after new values alone.
struct LeafCosts {
  Cost found, refreshed;
  double halo_leaves = 0; ///< of all processes
};
LeafCosts cost_of_leaves(const LeafLayout& layout);

} // namespace insitu::bench::scaling
