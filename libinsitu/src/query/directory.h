#pragma once

#include <span>
#include <vector>

#include "accel/tree/tree.h"
#include "mesh/box.h"
#include "parallel/world.h"

namespace insitu::query {

/// Where each process has cells: a few boxes a process, which together hold all of them.
class Directory {
public:
  static constexpr std::size_t most_boxes = 64; ///< of one process

  /// Collective. own: of this process's cells. Throws parallel::AgreedError.
  void gather(std::span<const mesh::Box> own, parallel::World& world);

  int size() const { return int(of_.size()); } ///< processes
  std::span<const mesh::Box> boxes(int rank) const { return of_[std::size_t(rank)].boxes; }
  /// Whether a process may hold the point.
  bool may_hold(int rank, const math::Vec3d& p) const;
  /// Whether the boxes of both processes meet somewhere.
  bool may_touch(int rank, int other) const;

private:
  struct Of {
    std::vector<mesh::Box> boxes;
    mesh::Box all; ///< of these, if there are any
  };
  std::vector<Of> of_; ///< [rank]
};

/// A box of a tree's frame in the mesh's coordinates, and back, both outwards.
mesh::Box in_mesh(const accel::Box& box, const math::Vec3d& origin);
accel::Box in_tree(const mesh::Box& box, const math::Vec3d& origin);
/// The boxes of a tree's two uppermost levels, in the mesh's coordinates.
std::vector<mesh::Box> boxes_of(const accel::Tree& tree);

} // namespace insitu::query
