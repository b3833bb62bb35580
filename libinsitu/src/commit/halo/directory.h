#pragma once

#include <span>
#include <vector>

#include "accel/tree/tree.h"
#include "mesh/box.h"
#include "parallel/world.h"

namespace insitu::commit {

/// Where each process has cells: a few boxes a process, which together hold all of them.
class Directory {
public:
  static constexpr std::size_t most_boxes = 64; ///< of one process

  /// Collective. tree: of this process's cells; empty where it has none.
  void gather(const accel::Tree& tree, parallel::World& world);

  std::span<const mesh::Box> boxes(int rank) const { return boxes_[std::size_t(rank)]; }
  /// Whether a process may hold the point.
  bool may_hold(int rank, const math::Vec3d& p) const;
  /// Whether the boxes of both processes meet somewhere.
  bool may_touch(int rank, int other) const;

private:
  std::vector<std::vector<mesh::Box>> boxes_; ///< [rank]
};

/// Closed boxes.
inline bool meet(const mesh::Box& a, const mesh::Box& b) {
  bool yes = true;
  for (int axis = 0; axis < 3; ++axis)
    yes &= a.low[axis] <= b.high[axis] && b.low[axis] <= a.high[axis];
  return yes;
}

} // namespace insitu::commit
