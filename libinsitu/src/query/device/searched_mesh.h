#pragma once

#include "accel/cuda/tree_node.h"
#include "device/kernel_mesh.h"

namespace insitu::query::on_device {

/// What kernels search for the cells of points.
struct SearchedMesh {
  device::KernelMesh mesh;
  accel::cuda::TreeView tree;
  bool alone = false; ///< a cell proven to hold the point strictly inside answers alone
};

} // namespace insitu::query::on_device
