// Boxes of floats and their quantised form only ever grow.
#include <cfloat>
#include <cstring>
#include <gtest/gtest.h>

#include "accel/tree/fit.h"
#include "accel/tree/node.h"
#include "core/random.h"

using namespace insitu;
using accel::Box;
using accel::Node;

namespace {

double unit(std::uint64_t item, std::uint64_t channel) {
  return core::random_unit(101, item, channel);
}
double signed_unit(std::uint64_t item, std::uint64_t channel) {
  return 2 * unit(item, channel) - 1;
}

} // namespace

TEST(Rounding, GoesOutwardsAndNotFar) {
  for (std::uint64_t i = 0; i < 200000; ++i) {
    // All exponents of float, subnormal ones and below included.
    const double x = std::ldexp(signed_unit(i, 0), int(unit(i, 1) * 288) - 160);
    const double lo = accel::round_down(x), hi = accel::round_up(x);
    ASSERT_LE(lo, x) << "item " << i;
    ASSERT_GE(hi, x) << "item " << i;
    ASSERT_GE(lo, x - std::fabs(x) * 0x1p-21 - 0x1p-119) << "item " << i;
    ASSERT_LE(hi, x + std::fabs(x) * 0x1p-21 + 0x1p-119) << "item " << i;
  }
  for (const double x : {0.0, -0.0, 5e-324, -5e-324, 1e-45, 1.0 + 0x1p-24, 1.0 - 0x1p-25}) {
    EXPECT_LE(double(accel::round_down(x)), x);
    EXPECT_GE(double(accel::round_up(x)), x);
  }
}

namespace {

/// Children within an offset and an extent of any size along each axis; some of no extent.
void random_children(std::uint64_t item, Node& node, Box* children) {
  for (int c = 0; c < 8; ++c)
    node.meta[c] = core::random_bits(102, item, std::uint64_t(c)) % 4 ? 1 : 0;
  node.meta[item % 8] = 1;
  for (int a = 0; a < 3; ++a) {
    const std::uint64_t axis = 3 * item + std::uint64_t(a);
    constexpr int offsets[] = {-1000, -149, -126, -60, -20, 0, 23, 60, 122};
    const int exponent = offsets[core::random_bits(103, axis, 0) % 9];
    const double offset = exponent == -1000 ? 0 : std::ldexp(signed_unit(axis, 2), exponent);
    const std::uint64_t kind = core::random_bits(103, axis, 1) % 4;
    const double extent = kind == 0   ? 0.0
                          : kind == 1 ? std::fabs(offset) * unit(axis, 3)
                                      : std::ldexp(1.0, int(unit(axis, 4) * 270) - 149);
    for (int c = 0; c < 8; ++c) {
      const std::uint64_t which = 8 * axis + std::uint64_t(c);
      auto lo = float(offset + extent * signed_unit(which, 5));
      auto hi = unit(which, 7) < 0.2 ? lo : float(offset + extent * signed_unit(which, 6));
      if (hi < lo)
        std::swap(lo, hi);
      children[c].lower[a] = lo;
      children[c].upper[a] = hi;
    }
  }
}

} // namespace

TEST(EncodeBoxes, NeverLosesAndStaysOnTheGrid) {
  for (std::uint64_t i = 0; i < 200000; ++i) {
    Node node{};
    Box children[8], all;
    random_children(i, node, children);
    Node fast = node;
    accel::encode_boxes(node, children);
    (void)accel::encode_node(fast, children);
    for (int a = 0; a < 3; ++a) { // but for the sign of zero
      ASSERT_EQ(fast.lower[a], node.lower[a]) << "item " << i;
      fast.lower[a] = node.lower[a];
    }
    ASSERT_EQ(std::memcmp(&fast, &node, sizeof node), 0) << "item " << i;
    for (int c = 0; c < 8; ++c)
      if (node.meta[c])
        all.extend(children[c]);
    for (int c = 0; c < 8; ++c) {
      const Box decoded = node.child_box(c);
      for (int a = 0; a < 3; ++a) {
        if (!node.meta[c]) {
          ASSERT_GT(decoded.lower[a], decoded.upper[a]) << "item " << i;
          continue;
        }
        ASSERT_LE(decoded.lower[a], children[c].lower[a]) << "item " << i << " axis " << a;
        ASSERT_GE(decoded.upper[a], children[c].upper[a]) << "item " << i << " axis " << a;
        // At most two steps too large; a step is at most twice 1/253 of the extent, or the ulps
        // of the largest coordinate, whichever is larger.
        const double step =
            std::max({2.0 * (double(all.upper[a]) - all.lower[a]) / 253,
                      (std::fabs(double(all.lower[a])) + std::fabs(double(all.upper[a]))) * 0x1p-22,
                      double(FLT_MIN)});
        ASSERT_GE(decoded.lower[a], children[c].lower[a] - 2 * step) << "item " << i;
        ASSERT_LE(decoded.upper[a], children[c].upper[a] + 2 * step) << "item " << i;
      }
    }
  }
}

TEST(Node, CountsItsChildrenInOrder) {
  Node node{};
  node.first_child = 100;
  node.first_cell = 50;
  node.inner = 0b10110010;
  node.meta[0] = (0 << 3) | 4;
  node.meta[2] = (4 << 3) | 1;
  node.meta[6] = (5 << 3) | 3;
  EXPECT_EQ(node.child_node(1), 100u);
  EXPECT_EQ(node.child_node(4), 101u);
  EXPECT_EQ(node.child_node(5), 102u);
  EXPECT_EQ(node.child_node(7), 103u);
  EXPECT_EQ(node.child_cells(6), 55u);
  EXPECT_EQ(node.child_cell_count(6), 3);
}
