#pragma once

#include <cstdint>

#include "accel/tree/node.h"

namespace insitu::accel::cuda {

/// An 8-wide node of 80 bytes: accel::Node with masks for its meta. Child boxes lie within
/// lower + 2^(exponent - 127) * [child_lower, child_upper] in real arithmetic. Inner children lie
/// at first_child in order, the cells of leaf children (one each) at first_cell.
struct alignas(16) TreeNode {
  float lower[3];
  std::uint8_t exponent[3];
  std::uint8_t inner; ///< bit i: child i is a node
  std::uint32_t first_child;
  std::uint32_t first_cell;
  std::uint8_t leaves; ///< bit i: child i is a cell
  std::uint8_t unused[7];
  std::uint8_t child_lower[3][8];
  std::uint8_t child_upper[3][8];
};
static_assert(sizeof(TreeNode) == 80);

/// The tree as kernels see it.
struct TreeView {
  const TreeNode* nodes = nullptr; ///< null if no cell owns points
  const std::uint32_t* cells = nullptr;
  math::Vec3d origin;
};

/// A tree is no deeper, whatever its cells: from `splits_end` on, ranges are halved by number.
constexpr int most_levels = 32, splits_end = 20;

} // namespace insitu::accel::cuda
