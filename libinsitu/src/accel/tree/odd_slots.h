#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "mesh/box.h"

namespace insitu::accel {

/// A few cells of a tree that a point inside may have several preimages in (cells::OddCells), by
/// their places in Tree::cells(): points that one of them may hold get no answer from a proof of
/// another alone.
class OddSlots {
public:
  OddSlots() = default;
  /// ids: flat, ascending; cells: the tree's.
  OddSlots(const mesh::MeshView& mesh, std::span<const std::int64_t> ids,
           std::span<const std::uint32_t> cells, const core::Threads& threads);

  bool empty() const { return slots_.empty(); }
  /// Of the cells, at the coordinates that they were marked at.
  std::span<const mesh::Box> boxes() const { return boxes_; }
  bool has(std::uint32_t slot) const {
    return (filter_ >> (slot & 63) & 1) != 0 &&
           std::binary_search(slots_.begin(), slots_.end(), slot);
  }
  /// Whether p is in the box of one of the cells.
  bool may_hold(const math::Vec3d& p) const;

private:
  std::uint64_t filter_ = 0; ///< bit (slot & 63) of each
  std::vector<std::uint32_t> slots_;
  std::vector<mesh::Box> boxes_;
  mesh::Box all_;
};

} // namespace insitu::accel
