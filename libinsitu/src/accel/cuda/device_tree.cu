#include "accel/cuda/device_tree.h"
#include "accel/cuda/device_tree_kernels.cuh"
#include "accel/tree/owners.h"
#include "core/status.h"
#include "device/algorithms.cuh"

namespace insitu::accel::cuda {

using device::Buffer;
using device::DeviceMesh;
using device::launch;
using device::StreamHandle;

DeviceTree::DeviceTree(core::Memory& memory)
    : nodes_(memory), cells_(memory), boxes_(memory),
      node_boxes_(memory), codes_{Buffer<std::uint64_t>(memory), Buffer<std::uint64_t>(memory)},
      order_(memory), splits_(memory), items_(memory), scratch_(memory), counters_(memory) {}

TreeView DeviceTree::view() const {
  return {cell_count_ > 0 ? nodes_.data() : nullptr, cells_.data(), origin_};
}

std::int64_t DeviceTree::bytes() const {
  return nodes_.bytes() + cells_.bytes();
}

std::int64_t DeviceTree::scratch_bytes() const {
  return boxes_.bytes() + node_boxes_.bytes() + codes_[0].bytes() + codes_[1].bytes() +
         order_.bytes() + splits_.bytes() + items_.bytes() + scratch_.bytes() + counters_.bytes();
}

void DeviceTree::release_scratch() {
  boxes_.release();
  node_boxes_.release();
  codes_[0].release();
  codes_[1].release();
  order_.release();
  splits_.release();
  items_.release();
  scratch_.release();
}

namespace {
std::uint32_t read_back(const std::uint32_t* p, StreamHandle stream) {
  std::uint32_t value = 0;
  device::copy_to_host(&value, p, sizeof value, stream, "reading a count");
  device::wait(stream, "building the tree");
  return value;
}
} // namespace

void DeviceTree::check_refused(const DeviceMesh& mesh, StreamHandle stream) {
  const std::uint32_t flat = read_back(counters_.data() + refused, stream);
  if (flat == none_refused)
    return;
  RefusedCells cells;
  cells.note(flat);
  cells.check(mesh.host_view());
}

/// The cells that own points, in order_[count, 2 count), or none where all do. Returns how many.
std::int64_t DeviceTree::collect_owners(const DeviceMesh& mesh, StreamHandle stream) {
  const std::int64_t n = mesh.cell_count();
  bool ghosts = false;
  for (std::int32_t p = 0; p < mesh.host_view().piece_count; ++p)
    ghosts = ghosts || mesh.host_view().pieces[p].ghosts;
  counters_.resize_discard(counter_count);
  order_.resize_discard(std::size_t(n) * (ghosts ? 3 : 2));
  device::fill(counters_.data(), 0xff, counter_count * sizeof(std::uint32_t), stream,
               "building the tree");
  if (!ghosts || n == 0)
    return n;
  device::select(scratch_, n, Owns{mesh.view()}, order_.data() + 2 * n, counters_.data() + selected,
                 stream, "selecting the cells that own points");
  return read_back(counters_.data() + selected, stream);
}

void DeviceTree::build(const DeviceMesh& mesh, StreamHandle stream) {
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
  launch(n, CellBoxesKernel{mesh.view(), ids, origin_, boxes_.data(), counters_.data() + refused},
         stream, "finding the cells' boxes");
  check_refused(mesh, stream);

  // Morton order of the boxes' centres.
  node_boxes_.resize_discard(1);
  device::reduce<std::uint32_t>(scratch_, n, TwiceCentre{boxes_.data(), ids}, JoinBoxes{}, Box{},
                                node_boxes_.data(), stream, "finding the centres' box");
  for (auto& codes : codes_)
    codes.resize_discard(n);
  launch(n, CodesKernel{boxes_.data(), ids, node_boxes_.data(), codes_[0].data(), order_.data()},
         stream, "making the cells' codes");
  const device::SortedPairs sorted =
      device::sort_pairs(scratch_, codes_[0].data(), codes_[1].data(), order_.data(),
                         order_.data() + all, n, stream, "sorting the cells");
  splits_.resize_discard(n);
  launch(n - 1, SplitsKernel{sorted.keys, n, splits_.data()}, stream, "finding the nodes' splits");
  make_topology(n, sorted.values, stream);
  cell_count_ = count;
  fit(mesh, true, stream);
  device::wait(stream, "building the tree");
}

/// Nodes level by level, breadth first, from the ranges of sorted cells that they hold.
void DeviceTree::make_topology(std::uint32_t n, const std::uint32_t* order, StreamHandle stream) {
  // Each node but the last ones has eight children, or children of up to eight cells.
  items_.resize_discard((std::size_t(n) * 2 / 3 + 16) * sizeof(TreeItem));
  auto* const items = reinterpret_cast<TreeItem*>(items_.data());
  auto* const counts = reinterpret_cast<std::uint32_t*>(codes_[0].data()); // codes are done with
  auto* const sums = reinterpret_cast<std::uint32_t*>(codes_[1].data());
  const TreeItem root{0, n - 1, 0, 0};
  device::copy_to_device(items, &root, sizeof root, stream, "building the tree");
  std::uint32_t begin = 0, end = 1;
  while (begin != end) {
    const int level = int(levels_.size());
    levels_.push_back(begin);
    const std::uint32_t count = end - begin;
    const bool halve = level >= splits_end;
    launch(count, CountChildrenKernel{items + begin, halve, splits_.data(), counts}, stream,
           "counting the nodes' children");
    device::running_sums(scratch_, counts, sums, count, stream, "numbering the nodes");
    launch(count, MakeItemsKernel{items + begin, halve, splits_.data(), sums, end, items}, stream,
           "making a level of the tree");
    begin = end;
    end += read_back(sums + count - 1, stream);
  }
  levels_.push_back(end);
  nodes_.resize_discard(end);
  cells_.resize_discard(n);
  const auto for_levels = [&](auto&& start) {
    for (std::size_t l = 0; l + 1 < levels_.size(); ++l)
      start(levels_[l], levels_[l + 1] - levels_[l], int(l) >= splits_end);
  };
  for_levels([&](std::uint32_t first, std::uint32_t count, bool halve) {
    launch(count, CountLeavesKernel{items, first, halve, splits_.data(), nodes_.data(), counts},
           stream, "making the nodes");
  });
  device::running_sums(scratch_, counts, sums, end, stream, "numbering the cells");
  for_levels([&](std::uint32_t first, std::uint32_t count, bool halve) {
    launch(count,
           PlaceCellsKernel{items, first, halve, splits_.data(), sums, order, nodes_.data(),
                            cells_.data()},
           stream, "placing the cells");
  });
}

void DeviceTree::fit(const DeviceMesh& mesh, bool from_boxes, StreamHandle stream) {
  node_boxes_.resize_discard(nodes_.size());
  for (std::size_t l = levels_.size() - 1; l-- > 0;) {
    const std::int64_t count = levels_[l + 1] - levels_[l];
    launch(8 * count,
           FitKernel{nodes_.data(), levels_[l], cells_.data(), from_boxes ? boxes_.data() : nullptr,
                     mesh.view(), origin_, node_boxes_.data(), counters_.data() + refused},
           stream, "fitting the nodes");
  }
}

void DeviceTree::refit(const DeviceMesh& mesh, StreamHandle stream) {
  if (cell_count_ == 0)
    return;
  device::fill(counters_.data(), 0xff, counter_count * sizeof(std::uint32_t), stream,
               "fitting the tree");
  fit(mesh, false, stream);
  check_refused(mesh, stream);
}

} // namespace insitu::accel::cuda
