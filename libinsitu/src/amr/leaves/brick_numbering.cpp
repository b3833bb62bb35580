#include "amr/leaves/brick_numbering.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace insitu::amr {

namespace {

constexpr int side = BrickStore::side;
using Order = BrickNumbering::Order;

/// The brick's order, if it has one.
bool find_order(const std::uint32_t* entries, Order& order) {
  std::int64_t least = 0, most = 0; // of an id, from the first
  for (int a = 0; a < 3; ++a) {
    std::int64_t low = 0, high = 0;
    for (int i = 0; i < side; ++i) {
      const std::uint32_t entry = entries[i << (3 * a)];
      if (!BrickStore::is_leaf(entry))
        return false;
      const std::int64_t offset = std::int64_t(entry) - std::int64_t(entries[0]);
      if (offset != std::int32_t(offset))
        return false;
      order.offsets[a][i] = std::int32_t(offset);
      low = std::min(low, offset), high = std::max(high, offset);
    }
    least += low, most += high;
  }
  // No sum wraps around, to an id or to what is none.
  if (least + std::int64_t(entries[0]) < 0 ||
      most + std::int64_t(entries[0]) >= std::int64_t(BrickStore::most_leaves))
    return false;
  std::uint32_t differ = 0;
  for (int k = 0; k < side; ++k)
    for (int j = 0; j < side; ++j) {
      const std::uint32_t* const row = entries + (j << 3 | k << 6);
      const std::uint32_t first = order.id(entries[0], 0, j, k);
      for (int i = 0; i < side; ++i)
        differ |= row[i] ^ (first + std::uint32_t(order.offsets[0][i]));
    }
  return differ == 0;
}

bool equal(const Order& a, const Order& b) {
  return std::memcmp(&a, &b, sizeof(Order)) == 0;
}
struct Equal {
  bool operator()(const Order& a, const Order& b) const { return equal(a, b); }
};
struct Hash {
  std::size_t operator()(const Order& order) const {
    return std::hash<std::string_view>()({reinterpret_cast<const char*>(&order), sizeof(Order)});
  }
};

} // namespace

void BrickNumbering::clear() {
  bricks_.resize_discard(0);
  orders_.resize_discard(0);
  numbered_ = 0;
}

void BrickNumbering::build(const BrickStore& store, const core::Threads& threads) {
  clear();
  const std::int64_t count = store.brick_count();
  bricks_.resize_discard(std::size_t(count));
  // Each grain finds its own orders; these are then brought together, in the bricks' order.
  constexpr std::int64_t grain = 64;
  std::vector<std::vector<Order>> found(std::size_t((count + grain - 1) / grain));
  threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Order>& own = found[std::size_t(begin / grain)];
    std::size_t last = 0;
    for (std::int64_t b = begin; b < end; ++b) {
      Order order;
      const std::uint32_t* const entries = store.entries(b);
      Brick& brick = bricks_[std::size_t(b)] = {entries[0], none};
      if (!find_order(entries, order))
        continue;
      if (last >= own.size() || !equal(own[last], order)) {
        for (last = 0; last < own.size() && !equal(own[last], order);)
          ++last;
        if (last == own.size())
          own.push_back(order);
      }
      brick.order = std::uint32_t(last);
    }
  });
  std::unordered_map<Order, std::uint32_t, Hash, Equal> known;
  std::vector<std::uint32_t> number;
  for (std::size_t g = 0; g < found.size(); ++g) {
    number.clear();
    for (const Order& order : found[g]) {
      const auto at = known.find(order);
      if (at != known.end()) {
        number.push_back(at->second);
      } else if (known.size() < most_orders) {
        number.push_back(std::uint32_t(known.size()));
        known.emplace(order, number.back());
        orders_.push_back(order);
      } else {
        number.push_back(none);
      }
    }
    const std::size_t begin = g * std::size_t(grain);
    for (std::size_t b = begin; b < std::min(begin + std::size_t(grain), bricks_.size()); ++b) {
      if (bricks_[b].order != none)
        bricks_[b].order = number[bricks_[b].order];
      numbered_ += bricks_[b].order != none;
    }
  }
}

} // namespace insitu::amr
