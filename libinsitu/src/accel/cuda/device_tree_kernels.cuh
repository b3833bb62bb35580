#pragma once

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_reduce.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>
#include "accel/cuda/device_tree.h"
#include "accel/cuda/launch.h"
#include "accel/cuda/topology.cuh"
#include "accel/cuda/tree_node.h"
#include "accel/tree/extent.h"
#include "accel/tree/owners.h"
#include "core/status.h"

/// The kernels that build and refit a tree on the device; DeviceTree alone starts them.
namespace insitu::accel::cuda {

namespace {

constexpr std::uint32_t none_refused = 0xffffffffu;

/// Counters on the device.
enum Counter { refused, selected, counter_count };

__device__ Box box_of(const mesh::MeshView& mesh, std::uint32_t flat, const math::Vec3d& origin,
                      std::uint32_t* first_refused) {
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
    atomicMin(first_refused, flat);
  return box;
}

struct Owns {
  mesh::MeshView mesh;
  __device__ bool operator()(std::uint32_t flat) const {
    const std::int32_t p = mesh.piece_of(flat);
    return mesh.pieces[p].exists(flat - mesh.first_cell[p]);
  }
};

__global__ void boxes_kernel(mesh::MeshView mesh, const std::uint32_t* ids, std::uint32_t count,
                             math::Vec3d origin, Box* boxes, std::uint32_t* first_refused) {
  const std::int64_t i = global_thread();
  if (i >= count)
    return;
  const std::uint32_t flat = ids ? ids[i] : std::uint32_t(i);
  boxes[flat] = box_of(mesh, flat, origin, first_refused);
}

/// Twice a box's centre, as a box.
struct TwiceCentre {
  const Box* boxes;
  const std::uint32_t* ids;
  __device__ Box operator()(std::uint32_t i) const {
    Box b = boxes[ids ? ids[i] : i];
    for (int a = 0; a < 3; ++a)
      b.lower[a] = b.upper[a] = b.lower[a] + b.upper[a];
    return b;
  }
};
struct JoinBoxes {
  __host__ __device__ Box operator()(Box a, const Box& b) const {
    a.extend(b);
    return a;
  }
};

__global__ void codes_kernel(const Box* boxes, const std::uint32_t* ids, std::uint32_t count,
                             const Box* centres, std::uint64_t* codes, std::uint32_t* order) {
  const std::int64_t i = global_thread();
  if (i >= count)
    return;
  const std::uint32_t flat = ids ? ids[i] : std::uint32_t(i);
  const Box box = boxes[flat];
  // One scale for all axes: a grid of cubes.
  float most = 0.0f;
  for (int a = 0; a < 3; ++a)
    most = fmaxf(most, centres->upper[a] - centres->lower[a]);
  const double scale = most > 0.0f ? 2097151.0 / double(most) : 0.0;
  std::uint64_t code = 0;
  for (int a = 0; a < 3; ++a) {
    const double at = (double(box.lower[a] + box.upper[a]) - double(centres->lower[a])) * scale;
    code |= math::spread_bits(std::uint64_t(at)) << a;
  }
  codes[i] = code;
  order[i] = flat;
}

__global__ void splits_kernel(const std::uint64_t* codes, std::uint32_t count,
                              std::uint32_t* splits) {
  const std::int64_t i = global_thread();
  if (i < std::int64_t(count) - 1)
    splits[i] = find_split(codes, count, std::uint32_t(i));
}

__global__ void count_children_kernel(const TreeItem* items, std::uint32_t count, bool halve,
                                      const std::uint32_t* splits, std::uint32_t* inner) {
  const std::int64_t i = global_thread();
  if (i >= count)
    return;
  const Opened opened(items[i], splits, halve);
  std::uint32_t n = 0;
  for (int c = 0; c < opened.count; ++c)
    n += opened.end[c] != opened.begin[c];
  inner[i] = n;
}

/// ends: of the inner children, counted over the level's items.
__global__ void make_items_kernel(TreeItem* level, std::uint32_t count, bool halve,
                                  const std::uint32_t* splits, const std::uint32_t* ends,
                                  std::uint32_t next, TreeItem* all) {
  const std::int64_t i = global_thread();
  if (i >= count)
    return;
  const Opened opened(level[i], splits, halve);
  std::uint32_t at = next + (i == 0 ? 0 : ends[i - 1]);
  level[i].first_child = at;
  for (int c = 0; c < opened.count; ++c)
    if (opened.end[c] != opened.begin[c])
      all[at++] = {opened.begin[c], opened.end[c], opened.index[c], 0};
}

__global__ void count_leaves_kernel(const TreeItem* items, std::uint32_t begin, std::uint32_t end,
                                    bool halve, const std::uint32_t* splits, TreeNode* nodes,
                                    std::uint32_t* leaves) {
  const std::int64_t i = begin + global_thread();
  if (i >= end)
    return;
  const Opened opened(items[i], splits, halve);
  TreeNode& node = nodes[i];
  unsigned inner = 0, leaf = 0;
  for (int c = 0; c < opened.count; ++c)
    (opened.end[c] != opened.begin[c] ? inner : leaf) |= 1u << c;
  node.inner = std::uint8_t(inner);
  node.leaves = std::uint8_t(leaf);
  node.first_child = items[i].first_child;
  leaves[i] = std::uint32_t(__popc(leaf));
}

__global__ void place_cells_kernel(const TreeItem* items, std::uint32_t begin, std::uint32_t end,
                                   bool halve, const std::uint32_t* splits,
                                   const std::uint32_t* ends, const std::uint32_t* order,
                                   TreeNode* nodes, std::uint32_t* cells) {
  const std::int64_t i = begin + global_thread();
  if (i >= end)
    return;
  const Opened opened(items[i], splits, halve);
  std::uint32_t at = i == 0 ? 0 : ends[i - 1];
  nodes[i].first_cell = at;
  for (int c = 0; c < opened.count; ++c)
    if (opened.end[c] == opened.begin[c])
      cells[at++] = order[opened.begin[c]];
}

/// Eight threads a node, one a child. Boxes of cells: given, or from the mesh.
__global__ void fit_kernel(TreeNode* nodes, std::uint32_t begin, std::uint32_t end,
                           const std::uint32_t* cells, const Box* cell_boxes, mesh::MeshView mesh,
                           math::Vec3d origin, Box* node_boxes, std::uint32_t* first_refused) {
  const std::int64_t thread = global_thread();
  const std::int64_t n = begin + thread / 8;
  const int child = int(thread % 8);
  const bool active = n < end;
  TreeNode& node = nodes[active ? n : begin];
  const unsigned inner = node.inner, leaves = node.leaves, below = (1u << child) - 1;
  const bool present = ((inner | leaves) >> child) & 1;
  Box box;
  if (present && active) {
    if ((inner >> child) & 1) {
      box = node_boxes[node.first_child + __popc(inner & below)];
    } else {
      const std::uint32_t flat = cells[node.first_cell + __popc(leaves & below)];
      box = cell_boxes ? cell_boxes[flat] : box_of(mesh, flat, origin, first_refused);
    }
  }
  Box all = box;
  for (int step = 1; step < 8; step *= 2)
    for (int a = 0; a < 3; ++a) {
      all.lower[a] = fminf(all.lower[a], __shfl_xor_sync(0xffffffffu, all.lower[a], step));
      all.upper[a] = fmaxf(all.upper[a], __shfl_xor_sync(0xffffffffu, all.upper[a], step));
    }
  if (!active)
    return;
  for (int a = 0; a < 3; ++a) {
    const std::uint8_t exponent = grid_exponent(all.lower[a], all.upper[a]);
    const float inverse = inverse_scale(exponent);
    const float l = floorf(__fsub_rd(box.lower[a], all.lower[a]) * inverse);
    const float u = ceilf(__fsub_ru(box.upper[a], all.lower[a]) * inverse);
    node.child_lower[a][child] = present ? std::uint8_t(fminf(fmaxf(l, 0.0f), 255.0f)) : 255;
    node.child_upper[a][child] = present ? std::uint8_t(fminf(fmaxf(u, 0.0f), 255.0f)) : 0;
    if (child == 0) {
      node.lower[a] = all.lower[a];
      node.exponent[a] = exponent;
    }
  }
  if (child == 0)
    node_boxes[n] = all;
}

} // namespace

} // namespace insitu::accel::cuda
