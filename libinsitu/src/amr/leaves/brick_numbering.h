#pragma once

#include <cstdint>

#include "amr/leaves/brick_store.h"
#include "core/memory.h"
#include "core/parallel.h"

namespace insitu::amr {

/// How ids run in the bricks that are full of leaves: in patches, and in octrees' leaves in Morton
/// order, an id is a sum of three numbers, one an axis. There it is told without the brick's
/// entries: 8 bytes a brick instead of 2048.
class BrickNumbering {
public:
  /// An order of ids, shared by many bricks: what the i-th, j-th and k-th cell along the axes add,
  /// [3][8].
  struct alignas(32) Order {
    std::int32_t offsets[3][BrickStore::side];
    std::uint32_t id(std::uint32_t first, int i, int j, int k) const {
      return first + std::uint32_t(offsets[0][i]) + std::uint32_t(offsets[1][j]) +
             std::uint32_t(offsets[2][k]);
    }
  };
  static constexpr std::uint32_t most_orders = 1024; ///< so that they stay in the cache

  explicit BrickNumbering(core::Memory& memory)
      : bricks_(memory, INSITU_MEMORY_AMR), orders_(memory, INSITU_MEMORY_AMR) {}

  void build(const BrickStore& store, const core::Threads& threads);
  void clear();

  /// A brick's order, and the id of its first leaf; null where some entries are no leaves or no
  /// such sums, and for all bricks before build().
  const Order* order_of(std::uint32_t brick, std::uint32_t& first) const {
    if (brick >= bricks_.size() || bricks_[brick].order == none)
      return nullptr;
    first = bricks_[brick].first;
    return &orders_[bricks_[brick].order];
  }
  std::int64_t numbered_count() const { return numbered_; }
  std::int64_t order_count() const { return std::int64_t(orders_.size()); }
  std::int64_t bytes() const { return std::int64_t(bricks_.bytes() + orders_.bytes()); }

private:
  static constexpr std::uint32_t none = 0xffffffff;
  struct Brick {
    std::uint32_t first, order;
  };
  core::Buffer<Brick> bricks_;
  core::Buffer<Order> orders_;
  std::int64_t numbered_ = 0;
};

} // namespace insitu::amr
