#pragma once

#include <cstdint>
#include <span>

#include "accel/morton/sort.h"
#include "accel/tree/tree.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "math/vec.h"

namespace insitu::query {

/// Whether most neighbours in the batch lie so many cells apart that sorting the batch costs less
/// than the misses of taking it as it is. Looks at a few dozen pairs.
bool is_incoherent(std::span<const math::Vec3d> points, const accel::Tree& tree);

/// Puts batches of points into spatial order. The memory is kept between batches.
class SpatialOrder {
public:
  explicit SpatialOrder(core::Memory& memory)
      : items_(memory, INSITU_MEMORY_QUERY), scratch_(memory, INSITU_MEMORY_QUERY) {}

  /// The points' numbers with their codes on a grid of the tree's box, in the order of these, equal
  /// codes in the points' own; at most 2^32 points. Valid until the next call. The same for any
  /// thread count.
  std::span<const accel::morton::Coded>
  sort(const core::Threads& threads, std::span<const math::Vec3d> points, const accel::Tree& tree);

  /// Gives the memory back.
  void release() {
    items_.release();
    scratch_.release();
  }

private:
  core::Buffer<accel::morton::Coded> items_, scratch_;
};

} // namespace insitu::query
