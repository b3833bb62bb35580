#pragma once

#include <cstdint>
#include <vector>

#include "accel/cuda/tree_node.h"
#include "accel/tree/node.h"
#include "device/device_mesh.h"

namespace insitu::accel::cuda {

/// The hierarchy of the `bvh` method, built and fitted on the device: 8-wide quantised nodes,
/// breadth first, over the owning cells in Morton order.
class DeviceTree {
public:
  explicit DeviceTree(core::Memory& memory);

  /// Both throw INSITU_ERROR_MESH for a cell whose coordinates no float holds; they return when
  /// done.
  void build(const device::DeviceMesh& mesh, device::StreamHandle stream);
  /// For moved vertices of the same topology.
  void refit(const device::DeviceMesh& mesh, device::StreamHandle stream);
  /// Scratch is kept between builds, as on the CPU.
  void release_scratch();

  TreeView view() const;
  std::int64_t cell_count() const { return cell_count_; }
  std::int64_t node_count() const { return levels_.empty() ? 0 : levels_.back(); }
  int depth() const { return levels_.empty() ? 0 : int(levels_.size()) - 1; }
  std::int64_t bytes() const;         ///< of nodes and cells
  std::int64_t scratch_bytes() const; ///< kept

private:
  std::int64_t collect_owners(const device::DeviceMesh& mesh, device::StreamHandle stream);
  void make_topology(std::uint32_t n, const std::uint32_t* order, device::StreamHandle stream);
  void fit(const device::DeviceMesh& mesh, bool from_boxes, device::StreamHandle stream);
  void check_refused(const device::DeviceMesh& mesh, device::StreamHandle stream);

  device::Buffer<TreeNode> nodes_;
  device::Buffer<std::uint32_t> cells_;
  std::vector<std::uint32_t> levels_; ///< first nodes, root first, and the number of nodes
  math::Vec3d origin_;
  std::int64_t cell_count_ = 0;
  // Scratch.
  device::Buffer<Box> boxes_;      ///< of cells, by flat id
  device::Buffer<Box> node_boxes_; ///< of nodes; also of refits
  device::Buffer<std::uint64_t> codes_[2];
  device::Buffer<std::uint32_t> order_, splits_;
  device::Buffer<std::byte> items_, scratch_;
  device::Buffer<std::uint32_t> counters_;
};

} // namespace insitu::accel::cuda
