#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "mesh/piece_borders.h"

namespace insitu::render {

/// Which vertices and cells of a mesh in longitude and latitude are the same in several places:
/// copies on its chart (commit::StandIn).
struct ChartCopies {
  /// Vertices that are one: of copies the solver's and each other, of pieces those that coincide.
  /// The first of each is no copy.
  mesh::JoinedVertices joined;
  /// Flat cells that are the second copy of one over the seam; the first is the cell before.
  /// Ascending.
  std::vector<std::int64_t> second;
  double turn = 0; ///< by multiples of which the first coordinates of one vertex differ

  bool is_second(std::int64_t flat) const { return std::ranges::binary_search(second, flat); }
};

} // namespace insitu::render
