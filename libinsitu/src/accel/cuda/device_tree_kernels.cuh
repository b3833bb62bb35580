#pragma once

#include <cmath>
#include <cstdint>

#include "accel/cuda/topology.cuh"
#include "accel/cuda/tree_node.h"
#include "accel/tree/extent.h"
#include "device/arithmetic.cuh"
#include "device/launch.cuh"
#include "math/morton.h"
#include "mesh/view.h"

/// The kernels that build and refit a tree on the device; DeviceTree alone starts them.
namespace insitu::accel::cuda {

constexpr std::uint32_t none_refused = 0xffffffffu;

/// Counters on the device.
enum Counter { refused, selected, counter_count };

INSITU_HD inline Box box_of(const mesh::MeshView& mesh, std::uint32_t flat,
                            const math::Vec3d& origin, std::uint32_t* first_refused) {
  mesh::CellVertices cell;
  mesh::gather(mesh, flat, cell);
  Box box;
  if (cell.count > 0) {
    Extent extent(cell.x[0]);
    for (int v = 1; v < cell.count; ++v)
      extent.add(cell.x[v]);
    box = extent.box(origin);
  }
  if (is_empty(box))
    device::lower_to(first_refused, flat);
  return box;
}

struct Owns {
  mesh::MeshView mesh;
  INSITU_HD bool operator()(std::uint32_t flat) const {
    const std::int32_t p = mesh.piece_of(flat);
    return mesh.pieces[p].exists(flat - mesh.first_cell[p]);
  }
};

struct CellBoxesKernel {
  mesh::MeshView mesh;
  const std::uint32_t* ids;
  math::Vec3d origin;
  Box* boxes;
  std::uint32_t* first_refused;
  INSITU_HD void operator()(std::int64_t i) const {
    const std::uint32_t flat = ids ? ids[i] : std::uint32_t(i);
    boxes[flat] = box_of(mesh, flat, origin, first_refused);
  }
};

/// Twice a box's centre, as a box.
struct TwiceCentre {
  const Box* boxes;
  const std::uint32_t* ids;
  INSITU_HD Box operator()(std::uint32_t i) const {
    Box b = boxes[ids ? ids[i] : i];
    for (int a = 0; a < 3; ++a)
      b.lower[a] = b.upper[a] = b.lower[a] + b.upper[a];
    return b;
  }
};
struct JoinBoxes {
  INSITU_HD Box operator()(Box a, const Box& b) const {
    a.extend(b);
    return a;
  }
};

struct CodesKernel {
  const Box* boxes;
  const std::uint32_t* ids;
  const Box* centres;
  std::uint64_t* codes;
  std::uint32_t* order;
  INSITU_HD void operator()(std::int64_t i) const {
    const std::uint32_t flat = ids ? ids[i] : std::uint32_t(i);
    const Box box = boxes[flat];
    // One scale for all axes: a grid of cubes.
    float most = 0.0f;
    for (int a = 0; a < 3; ++a)
      most = std::fmax(most, centres->upper[a] - centres->lower[a]);
    const double scale = most > 0.0f ? 2097151.0 / double(most) : 0.0;
    std::uint64_t code = 0;
    for (int a = 0; a < 3; ++a) {
      const double at = (double(box.lower[a] + box.upper[a]) - double(centres->lower[a])) * scale;
      code |= math::spread_bits(std::uint64_t(at)) << a;
    }
    codes[i] = code;
    order[i] = flat;
  }
};

/// Of all inner nodes of the radix tree, one less than codes.
struct SplitsKernel {
  const std::uint64_t* codes;
  std::uint32_t count; ///< of codes
  std::uint32_t* splits;
  INSITU_HD void operator()(std::int64_t i) const {
    splits[i] = find_split(codes, count, std::uint32_t(i));
  }
};

struct CountChildrenKernel {
  const TreeItem* items;
  bool halve;
  const std::uint32_t* splits;
  std::uint32_t* inner;
  INSITU_HD void operator()(std::int64_t i) const {
    const Opened opened(items[i], splits, halve);
    std::uint32_t n = 0;
    for (int c = 0; c < opened.count; ++c)
      n += opened.end[c] != opened.begin[c];
    inner[i] = n;
  }
};

/// ends: of the inner children, counted over the level's items.
struct MakeItemsKernel {
  TreeItem* level;
  bool halve;
  const std::uint32_t* splits;
  const std::uint32_t* ends;
  std::uint32_t next;
  TreeItem* all;
  INSITU_HD void operator()(std::int64_t i) const {
    const Opened opened(level[i], splits, halve);
    std::uint32_t at = next + (i == 0 ? 0 : ends[i - 1]);
    level[i].first_child = at;
    for (int c = 0; c < opened.count; ++c)
      if (opened.end[c] != opened.begin[c])
        all[at++] = {opened.begin[c], opened.end[c], opened.index[c], 0};
  }
};

struct CountLeavesKernel {
  const TreeItem* items;
  std::uint32_t begin; ///< the first node of the level
  bool halve;
  const std::uint32_t* splits;
  TreeNode* nodes;
  std::uint32_t* leaves;
  INSITU_HD void operator()(std::int64_t in_level) const {
    const std::int64_t i = begin + in_level;
    const Opened opened(items[i], splits, halve);
    TreeNode& node = nodes[i];
    unsigned inner = 0, leaf = 0;
    for (int c = 0; c < opened.count; ++c)
      (opened.end[c] != opened.begin[c] ? inner : leaf) |= 1u << c;
    node.inner = std::uint8_t(inner);
    node.leaves = std::uint8_t(leaf);
    node.first_child = items[i].first_child;
    leaves[i] = std::uint32_t(device::count_bits(leaf));
  }
};

struct PlaceCellsKernel {
  const TreeItem* items;
  std::uint32_t begin; ///< the first node of the level
  bool halve;
  const std::uint32_t* splits;
  const std::uint32_t* ends;
  const std::uint32_t* order;
  TreeNode* nodes;
  std::uint32_t* cells;
  INSITU_HD void operator()(std::int64_t in_level) const {
    const std::int64_t i = begin + in_level;
    const Opened opened(items[i], splits, halve);
    std::uint32_t at = i == 0 ? 0 : ends[i - 1];
    nodes[i].first_cell = at;
    for (int c = 0; c < opened.count; ++c)
      if (opened.end[c] == opened.begin[c])
        cells[at++] = order[opened.begin[c]];
  }
};

/// Eight items a node, one a child, so that a card has eight threads a node. Boxes of cells: given,
/// or from the mesh.
struct FitKernel {
  TreeNode* nodes;
  std::uint32_t begin; ///< the first node of the level
  const std::uint32_t* cells;
  const Box* cell_boxes;
  mesh::MeshView mesh;
  math::Vec3d origin;
  Box* node_boxes;
  std::uint32_t* first_refused;

  INSITU_HD void operator()(std::int64_t i) const {
    const std::int64_t n = begin + i / 8;
    const int child = int(i % 8);
    TreeNode& node = nodes[n];
    const bool present = ((node.inner | node.leaves) >> child) & 1;
    const Box box = box_of_child(node, child);
    const Box all = joined(node, box);
    for (int a = 0; a < 3; ++a) {
      const std::uint8_t exponent = grid_exponent(all.lower[a], all.upper[a]);
      const float inverse = inverse_scale(exponent);
      const float l = std::floor(device::difference_below(box.lower[a], all.lower[a]) * inverse);
      const float u = std::ceil(device::difference_above(box.upper[a], all.lower[a]) * inverse);
      node.child_lower[a][child] = present ? in_a_byte(l) : 255;
      node.child_upper[a][child] = present ? in_a_byte(u) : 0;
      if (child == 0) {
        node.lower[a] = all.lower[a];
        node.exponent[a] = exponent;
      }
    }
    if (child == 0)
      node_boxes[n] = all;
  }

private:
  /// The box of a child, empty where there is none.
  INSITU_HD Box box_of_child(const TreeNode& node, int child) const {
    const unsigned inner = node.inner, leaves = node.leaves, below = (1u << child) - 1;
    if ((inner >> child) & 1)
      return node_boxes[node.first_child + unsigned(device::count_bits(inner & below))];
    if (!((leaves >> child) & 1))
      return Box{};
    const std::uint32_t flat =
        cells[node.first_cell + unsigned(device::count_bits(leaves & below))];
    return cell_boxes ? cell_boxes[flat] : box_of(mesh, flat, origin, first_refused);
  }

  /// The box of all children: from the seven threads beside this one, or one after the other.
  INSITU_HD Box joined(const TreeNode& node, Box all) const {
#if defined(__CUDA_ARCH__)
    (void)node;
    const unsigned eight = 0xffu << (threadIdx.x & 24u);
    for (int step = 1; step < 8; step *= 2)
      for (int a = 0; a < 3; ++a) {
        all.lower[a] = fminf(all.lower[a], __shfl_xor_sync(eight, all.lower[a], step));
        all.upper[a] = fmaxf(all.upper[a], __shfl_xor_sync(eight, all.upper[a], step));
      }
#else
    for (int c = 0; c < 8; ++c)
      all.extend(box_of_child(node, c));
#endif
    return all;
  }

  INSITU_HD static std::uint8_t in_a_byte(float a) {
    return std::uint8_t(std::fmin(std::fmax(a, 0.0f), 255.0f));
  }
};

} // namespace insitu::accel::cuda
