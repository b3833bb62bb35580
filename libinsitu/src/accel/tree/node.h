#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "math/hd.h"
#include "math/vec.h"

namespace insitu::accel {

/// A box of floats in the local frame of the tree.
struct Box {
  float lower[3] = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
                    std::numeric_limits<float>::infinity()};
  float upper[3] = {-std::numeric_limits<float>::infinity(),
                    -std::numeric_limits<float>::infinity(),
                    -std::numeric_limits<float>::infinity()};

  INSITU_HD void extend(const Box& b) {
    for (int a = 0; a < 3; ++a) {
      lower[a] = b.lower[a] < lower[a] ? b.lower[a] : lower[a];
      upper[a] = b.upper[a] > upper[a] ? b.upper[a] : upper[a];
    }
  }
  INSITU_HD float half_area() const {
    const float x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
    return x * y + y * z + z * x;
  }
};

/// round_down returns a float at or below the double, round_up one at or above it. Rounding to
/// nearest errs by half an ulp at most, and 2^-22 of the value is more than an ulp.
INSITU_HD inline float round_down(double x) {
  const float f = float(x);
  return f - std::fabs(f) * 0x1p-22f - 0x1p-120f;
}
INSITU_HD inline float round_up(double x) {
  const float f = float(x);
  return f + std::fabs(f) * 0x1p-22f + 0x1p-120f;
}

/// Returns one over the spacing of a grid. The result is exact, but zero for the largest spacing,
/// which only boxes beyond 1e37 need.
INSITU_HD inline float inverse_scale(std::uint8_t exponent) {
  return std::bit_cast<float>((254u - std::uint32_t(exponent)) << 23);
}

/// Node::depth makes the distances to faces larger by this part of a step of the grid of the node,
/// so that a distance of 0 is never -0, whose sign would put the query outside. No query depends on
/// so small a part of a step.
constexpr float depth_slack = 0x1p-14f;

constexpr float whole_steps = 0x1p23f; ///< adding this number rounds a float below 2^22 to its
                                       ///< nearest integer, which the low bits of the sum hold

/// A node of 80 bytes with up to 8 children. The boxes of the children are quantised, outwards, to
/// 8 bits on a grid whose spacing is a power of two per axis: lower + 2^(exponent - 127) * byte,
/// exact but for one rounding, which encoding has checked. Inner children lie at first_child, in
/// order. The meta & 7 cells of a leaf child lie at first_cell + (meta >> 3). meta is 0 where there
/// is no child.
struct alignas(16) Node {
  float lower[3];
  std::uint8_t exponent[3];
  std::uint8_t inner; ///< bit i: child i is a node
  std::uint32_t first_child;
  std::uint32_t first_cell;
  std::uint8_t meta[8];
  std::uint8_t child_lower[3][8];
  std::uint8_t child_upper[3][8];

  INSITU_HD float scale(int axis) const {
    return std::bit_cast<float>(std::uint32_t(exponent[axis]) << 23);
  }
  /// Returns the children that there are: bit c stands for child c.
  unsigned children() const {
    // Each byte that is not 0 gives its high bit; the product lays these eight bits side by side.
    constexpr std::uint64_t low = 0x7f7f7f7f7f7f7f7full;
    const std::uint64_t all = std::bit_cast<std::uint64_t>(meta);
    const std::uint64_t high = (((all & low) + low) | all) & ~low;
    return unsigned(((high >> 7) * 0x0102040810204080ull) >> 56);
  }
  INSITU_HD bool is_inner(int child) const { return (inner >> child) & 1; }
  INSITU_HD std::uint32_t child_node(int child) const {
    return first_child + std::uint32_t(std::popcount(unsigned(inner) & ((1u << child) - 1u)));
  }
  INSITU_HD std::uint32_t child_cells(int child) const {
    return first_cell + (std::uint32_t(meta[child]) >> 3);
  }
  INSITU_HD int child_cell_count(int child) const { return meta[child] & 7; }
  INSITU_HD Box child_box(int child) const {
    Box b;
    for (int a = 0; a < 3; ++a) {
      const float s = scale(a);
      b.lower[a] = lower[a] + s * float(child_lower[a][child]);
      b.upper[a] = lower[a] + s * float(child_upper[a][child]);
    }
    return b;
  }
  /// Returns how far a box [lower, upper] reaches into the box of a child, in steps of the grid, 0
  /// to 255. Scaling by a power of two is exact, so the signs are those that child_box gives.
  INSITU_HD std::uint8_t depth(int child, const float* box_lower, const float* box_upper) const {
    float least = 255.0f;
    for (int a = 0; a < 3; ++a) {
      const float inverse = inverse_scale(exponent[a]), corner = lower[a] * inverse;
      const float low = -float(child_lower[a][child]) - corner + depth_slack;
      const float high = float(child_upper[a][child]) + corner + depth_slack;
      const float from_lower = box_upper[a] * inverse + low;
      const float to_upper = high - box_lower[a] * inverse;
      const float steps = from_lower < to_upper ? from_lower : to_upper;
      least = steps < least ? steps : least;
    }
    least = least > 0.0f ? least : 0.0f;
    return std::uint8_t(std::bit_cast<std::uint32_t>(least + whole_steps) & 255u);
  }
};
static_assert(sizeof(Node) == 80);

constexpr int most_leaf_cells = 1; ///< the builders put one cell into a leaf; the format could hold
                                   ///< four

/// Returns the biased exponent of the smallest power of two with extent / 2^e <= 254; one spare
/// step takes the roundings. The power is not below the ulp of lo or hi, or steps would vanish in
/// the sum.
INSITU_HD inline std::uint8_t grid_exponent(float lo, float hi) {
  const float at_least = (std::fabs(lo) + std::fabs(hi)) * 0x1p-23f;
  float unit = (hi - lo) * (1.0f / 253.0f);
  unit = unit > at_least ? unit : at_least;
  const std::uint32_t e = (std::bit_cast<std::uint32_t>(unit) + 0x7fffffu) >> 23;
  return std::uint8_t(e < 1 ? 1 : (e > 254 ? 254 : e));
}

/// Quantises the boxes of the children into the node, outwards. Children whose meta is 0 get an
/// inverted box. accel/tree/fit.h does the same faster.
INSITU_HD inline void encode_boxes(Node& node, const Box* children) {
  Box all;
  for (int c = 0; c < 8; ++c)
    if (node.meta[c])
      all.extend(children[c]);
  for (int a = 0; a < 3; ++a) {
    const float lo = all.lower[a];
    node.lower[a] = lo;
    node.exponent[a] = grid_exponent(lo, all.upper[a]);
    const float s = node.scale(a), inverse = inverse_scale(node.exponent[a]);
    for (int c = 0; c < 8; ++c) {
      if (!node.meta[c]) {
        node.child_lower[a][c] = 255;
        node.child_upper[a][c] = 0;
        continue;
      }
      float l = std::floor((children[c].lower[a] - lo) * inverse);
      float u = std::ceil((children[c].upper[a] - lo) * inverse);
      l = l < 0.0f ? 0.0f : (l > 255.0f ? 255.0f : l);
      u = u < 0.0f ? 0.0f : (u > 255.0f ? 255.0f : u);
      while (l > 0.0f && lo + s * l > children[c].lower[a])
        l -= 1.0f;
      while (u < 255.0f && lo + s * u < children[c].upper[a])
        u += 1.0f;
      node.child_lower[a][c] = std::uint8_t(l);
      node.child_upper[a][c] = std::uint8_t(u);
    }
  }
}

} // namespace insitu::accel
