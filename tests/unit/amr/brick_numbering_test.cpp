// Bricks whose ids are sums of three numbers, against their entries one by one.
#include <functional>
#include <gtest/gtest.h>
#include <limits>

#include "amr/leaves/brick_numbering.h"
#include "core/random.h"

using namespace insitu;

namespace {

using amr::BrickNumbering;
using amr::BrickStore;

class Bricks {
public:
  explicit Bricks(int count, int thread_limit = 1)
      : threads(thread_limit), store(memory), numbering(memory) {
    amr::BrickKeys keys;
    for (int b = 0; b < count; ++b)
      keys[0].push_back({b, 0, 0});
    store.create(keys, threads);
  }
  void fill(std::int64_t brick, const std::function<std::int64_t(int i, int j, int k)>& id) {
    for (int e = 0; e < BrickStore::brick_entries; ++e)
      store.entries(brick)[e] = std::uint32_t(id(e & 7, e >> 3 & 7, e >> 6));
  }
  /// Whether a brick has an order; checks what it tells.
  bool has_order(std::uint32_t brick) {
    std::uint32_t first = 0;
    const BrickNumbering::Order* const order = numbering.order_of(brick, first);
    for (int e = 0; e < BrickStore::brick_entries && order; ++e)
      EXPECT_EQ(order->id(first, e & 7, e >> 3 & 7, e >> 6), store.entries(brick)[e])
          << "brick " << brick << ", entry " << e;
    return order != nullptr;
  }

  core::Memory memory;
  core::Threads threads;
  BrickStore store;
  BrickNumbering numbering;
};

std::int64_t rows(int i, int j, int k) {
  return 5000 + i + 16 * j + 256 * k;
}

} // namespace

TEST(BrickNumbering, TellsWhatTheEntriesSay) {
  Bricks b(9);
  EXPECT_FALSE(b.has_order(0)) << "not built yet";
  b.fill(0, rows);
  b.fill(1, [](int i, int j, int k) { return 90000 - 3 * i - 100 * j + 1000 * k; });
  b.fill(2, [](int i, int j, int k) { // Morton order
    std::int64_t id = 0;
    for (int bit = 0; bit < 3; ++bit)
      id |= std::int64_t(((i >> bit) & 1) | ((j >> bit) & 1) << 1 | ((k >> bit) & 1) << 2)
            << (3 * bit);
    return id;
  });
  b.fill(3, [](int i, int j, int k) { return rows(i, j, k) + (i == 7 && j == 7 && k == 7); });
  b.fill(4, [](int i, int j, int k) {
    return i == 3 && j == 1 && k == 2 ? std::int64_t(BrickStore::refined) : rows(i, j, k);
  });
  b.fill(5, [](int, int, int) { return std::int64_t(BrickStore::nothing); });
  b.fill(6, [](int i, int j, int k) { return i * j + 10000 * k; });
  b.fill(7, [](int i, int j, int k) { return rows(i, j, k) + 70000; }); // the first one's order
  // The 8th is left as it was made: nothing in it.
  b.numbering.build(b.store, b.threads);
  for (std::uint32_t brick = 0; brick < 9; ++brick)
    EXPECT_EQ(b.has_order(brick), brick < 3 || brick == 7) << brick;
  EXPECT_EQ(b.numbering.numbered_count(), 4);
  EXPECT_EQ(b.numbering.order_count(), 3);
  EXPECT_FALSE(b.has_order(9)) << "no such brick";
  b.numbering.clear();
  EXPECT_FALSE(b.has_order(0));
}

TEST(BrickNumbering, IdsAtTheEndsOfTheirRange) {
  Bricks b(5);
  const auto last = std::int64_t(BrickStore::most_leaves) - 1;
  b.fill(0, [&](int i, int j, int k) { return last - (i + 8 * j + 64 * k); });
  b.fill(1, [&](int i, int j, int k) { return i + 8 * j + 64 * k == 511 ? last : rows(i, j, k); });
  // Further apart than 32 bits with a sign tell.
  b.fill(2, [](int i, int j, int k) { return (i == 7 ? 3'000'000'000 : i) + 8 * j + 64 * k; });
  // Sums that wrap around, though none does along an axis alone.
  b.fill(3, [](int i, int j, int k) {
    return (4'294'960'000 + 1000 * i + 1000 * j + k) & 0xffffffff;
  });
  b.fill(4, [](int i, int j, int k) { return std::int64_t(0x7fffffff) + i + 8 * j + 64 * k; });
  b.numbering.build(b.store, b.threads);
  for (std::uint32_t brick = 0; brick < 5; ++brick)
    EXPECT_EQ(b.has_order(brick), brick == 0 || brick == 4) << brick;
}

TEST(BrickNumbering, MoreOrdersThanAreKept) {
  const int count = int(BrickNumbering::most_orders) + 300;
  std::vector<bool> expected;
  for (const int thread_limit : {1, 2}) {
    Bricks b(count, thread_limit);
    for (int n = 0; n < count; ++n) {
      const int along_x = n % 50 == 49 ? 1 : n + 1; // each fiftieth as the first
      b.fill(n, [&](int i, int j, int k) { return n + along_x * i + 20000 * j + 200000 * k; });
    }
    b.numbering.build(b.store, b.threads);
    EXPECT_EQ(b.numbering.order_count(), std::int64_t(BrickNumbering::most_orders));
    std::vector<bool> ordered;
    for (int n = 0; n < count; ++n)
      ordered.push_back(b.has_order(std::uint32_t(n)));
    EXPECT_TRUE(ordered[0] && ordered[std::size_t(count - 1)] == ((count - 1) % 50 == 49));
    EXPECT_TRUE(ordered[1299]) << "the first one's order, behind all that are kept";
    EXPECT_FALSE(ordered[1298]);
    EXPECT_TRUE(expected.empty() || expected == ordered) << "threads";
    expected = ordered;
  }
}
