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
#include "accel/cuda/device_tree_kernels.cuh"

namespace insitu::accel::cuda {

DeviceTree::DeviceTree(core::Memory& memory)
    : nodes_(memory), cells_(memory), boxes_(memory),
      node_boxes_(memory), codes_{DeviceBuffer<std::uint64_t>(memory),
                                  DeviceBuffer<std::uint64_t>(memory)},
      order_(memory), splits_(memory), items_(memory), cub_(memory), counters_(memory) {}

TreeView DeviceTree::view() const {
  return {cell_count_ > 0 ? nodes_.data() : nullptr, cells_.data(), origin_};
}

std::int64_t DeviceTree::bytes() const {
  return nodes_.bytes() + cells_.bytes();
}

std::int64_t DeviceTree::scratch_bytes() const {
  return boxes_.bytes() + node_boxes_.bytes() + codes_[0].bytes() + codes_[1].bytes() +
         order_.bytes() + splits_.bytes() + items_.bytes() + cub_.bytes() + counters_.bytes();
}

void DeviceTree::release_scratch() {
  boxes_.release();
  node_boxes_.release();
  codes_[0].release();
  codes_[1].release();
  order_.release();
  splits_.release();
  items_.release();
  cub_.release();
}

/// Asks an algorithm of CUB for its memory and runs it.
template <class F>
void DeviceTree::with_scratch(const char* what, F&& call) {
  std::size_t bytes = 0;
  check(call(static_cast<void*>(nullptr), bytes), what);
  cub_.resize_discard(bytes + 1); // null would ask again
  check(call(static_cast<void*>(cub_.data()), bytes), what);
}

namespace {
std::uint32_t read_back(const std::uint32_t* p, cudaStream_t stream) {
  std::uint32_t value = 0;
  check(cudaMemcpyAsync(&value, p, sizeof value, cudaMemcpyDeviceToHost, stream),
        "reading a count");
  check(cudaStreamSynchronize(stream), "building the tree");
  return value;
}
} // namespace

void DeviceTree::check_refused(const DeviceMesh& mesh, cudaStream_t stream) {
  const std::uint32_t flat = read_back(counters_.data() + refused, stream);
  if (flat == none_refused)
    return;
  RefusedCells cells;
  cells.note(flat);
  cells.check(mesh.host_view());
}

/// The cells that own points, in order_[count, 2 count), or none where all do. Returns how many.
std::int64_t DeviceTree::collect_owners(const DeviceMesh& mesh, cudaStream_t stream) {
  const std::int64_t n = mesh.cell_count();
  bool ghosts = false;
  for (std::int32_t p = 0; p < mesh.host_view().piece_count; ++p)
    ghosts = ghosts || mesh.host_view().pieces[p].ghosts;
  counters_.resize_discard(counter_count);
  order_.resize_discard(std::size_t(n) * (ghosts ? 3 : 2));
  check(cudaMemsetAsync(counters_.data(), 0xff, counter_count * sizeof(std::uint32_t), stream),
        "building the tree");
  if (!ghosts || n == 0)
    return n;
  with_scratch("selecting the cells that own points", [&](void* scratch, std::size_t& bytes) {
    return cub::DeviceSelect::If(scratch, bytes, thrust::counting_iterator<std::uint32_t>(0),
                                 order_.data() + 2 * n, counters_.data() + selected, n,
                                 Owns{mesh.view()}, stream);
  });
  return read_back(counters_.data() + selected, stream);
}

void DeviceTree::build(const DeviceMesh& mesh, cudaStream_t stream) {
  levels_.clear();
  origin_ = mesh.origin();
  cell_count_ = 0; // until it is built
  const std::int64_t count = collect_owners(mesh, stream);
  if (count == 0) {
    nodes_.resize_discard(0);
    cells_.resize_discard(0);
    return;
  }
  const auto n = std::uint32_t(count);
  const std::int64_t all = mesh.cell_count();
  const std::uint32_t* ids =
      order_.size() == std::size_t(3 * all) ? order_.data() + 2 * all : nullptr;
  boxes_.resize_discard(std::size_t(all));
  boxes_kernel<<<blocks_for(n), threads_a_block, 0, stream>>>(
      mesh.view(), ids, n, origin_, boxes_.data(), counters_.data() + refused);
  check_launch("finding the cells' boxes");
  check_refused(mesh, stream);

  // Morton order of the boxes' centres.
  node_boxes_.resize_discard(1);
  const auto centres = thrust::make_transform_iterator(thrust::counting_iterator<std::uint32_t>(0),
                                                       TwiceCentre{boxes_.data(), ids});
  with_scratch("finding the centres' box", [&](void* scratch, std::size_t& bytes) {
    return cub::DeviceReduce::Reduce(scratch, bytes, centres, node_boxes_.data(), std::int64_t(n),
                                     JoinBoxes{}, Box{}, stream);
  });
  for (auto& codes : codes_)
    codes.resize_discard(n);
  codes_kernel<<<blocks_for(n), threads_a_block, 0, stream>>>(
      boxes_.data(), ids, n, node_boxes_.data(), codes_[0].data(), order_.data());
  check_launch("making the cells' codes");
  cub::DoubleBuffer<std::uint64_t> keys(codes_[0].data(), codes_[1].data());
  cub::DoubleBuffer<std::uint32_t> values(order_.data(), order_.data() + all);
  with_scratch("sorting the cells", [&](void* scratch, std::size_t& bytes) {
    return cub::DeviceRadixSort::SortPairs(scratch, bytes, keys, values, std::int64_t(n), 0, 63,
                                           stream);
  });
  splits_.resize_discard(n);
  if (n > 1)
    splits_kernel<<<blocks_for(n - 1), threads_a_block, 0, stream>>>(keys.Current(), n,
                                                                     splits_.data());
  check_launch("finding the nodes' splits");
  make_topology(n, values.Current(), stream);
  cell_count_ = count;
  fit(mesh, true, stream);
  check(cudaStreamSynchronize(stream), "building the tree");
}

/// Nodes level by level, breadth first, from the ranges of sorted cells that they hold.
void DeviceTree::make_topology(std::uint32_t n, const std::uint32_t* order, cudaStream_t stream) {
  // Each node but the last ones has eight children, or children of up to eight cells.
  items_.resize_discard((std::size_t(n) * 2 / 3 + 16) * sizeof(TreeItem));
  auto* const items = reinterpret_cast<TreeItem*>(items_.data());
  auto* const counts = reinterpret_cast<std::uint32_t*>(codes_[0].data()); // codes are done with
  auto* const sums = reinterpret_cast<std::uint32_t*>(codes_[1].data());
  const TreeItem root{0, n - 1, 0, 0};
  check(cudaMemcpyAsync(items, &root, sizeof root, cudaMemcpyHostToDevice, stream),
        "building the tree");
  std::uint32_t begin = 0, end = 1;
  while (begin != end) {
    const int level = int(levels_.size());
    levels_.push_back(begin);
    const std::uint32_t count = end - begin;
    const bool halve = level >= splits_end;
    count_children_kernel<<<blocks_for(count), threads_a_block, 0, stream>>>(
        items + begin, count, halve, splits_.data(), counts);
    check_launch("counting the nodes' children");
    with_scratch("numbering the nodes", [&](void* scratch, std::size_t& bytes) {
      return cub::DeviceScan::InclusiveSum(scratch, bytes, counts, sums, std::int64_t(count),
                                           stream);
    });
    make_items_kernel<<<blocks_for(count), threads_a_block, 0, stream>>>(
        items + begin, count, halve, splits_.data(), sums, end, items);
    check_launch("making a level of the tree");
    begin = end;
    end += read_back(sums + count - 1, stream);
  }
  levels_.push_back(end);
  nodes_.resize_discard(end);
  cells_.resize_discard(n);
  const auto for_levels = [&](auto&& launch) {
    for (std::size_t l = 0; l + 1 < levels_.size(); ++l)
      launch(levels_[l], levels_[l + 1], int(l) >= splits_end);
    check_launch("making the nodes");
  };
  for_levels([&](std::uint32_t first, std::uint32_t last, bool halve) {
    count_leaves_kernel<<<blocks_for(last - first), threads_a_block, 0, stream>>>(
        items, first, last, halve, splits_.data(), nodes_.data(), counts);
  });
  with_scratch("numbering the cells", [&](void* scratch, std::size_t& bytes) {
    return cub::DeviceScan::InclusiveSum(scratch, bytes, counts, sums, std::int64_t(end), stream);
  });
  for_levels([&](std::uint32_t first, std::uint32_t last, bool halve) {
    place_cells_kernel<<<blocks_for(last - first), threads_a_block, 0, stream>>>(
        items, first, last, halve, splits_.data(), sums, order, nodes_.data(), cells_.data());
  });
}

void DeviceTree::fit(const DeviceMesh& mesh, bool from_boxes, cudaStream_t stream) {
  node_boxes_.resize_discard(nodes_.size());
  for (std::size_t l = levels_.size() - 1; l-- > 0;) {
    const std::uint32_t first = levels_[l], last = levels_[l + 1];
    fit_kernel<<<blocks_for(8 * std::int64_t(last - first)), threads_a_block, 0, stream>>>(
        nodes_.data(), first, last, cells_.data(), from_boxes ? boxes_.data() : nullptr,
        mesh.view(), origin_, node_boxes_.data(), counters_.data() + refused);
  }
  check_launch("fitting the nodes");
}

void DeviceTree::refit(const DeviceMesh& mesh, cudaStream_t stream) {
  if (cell_count_ == 0)
    return;
  check(cudaMemsetAsync(counters_.data(), 0xff, counter_count * sizeof(std::uint32_t), stream),
        "fitting the tree");
  fit(mesh, false, stream);
  check_refused(mesh, stream);
}

} // namespace insitu::accel::cuda
