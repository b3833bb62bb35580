#pragma once

#include <cstdint>

#include "accel/embree/device.h"
#include "accel/node.h"

namespace insitu::accel::embree {

/// What Embree's build makes, in memory of the RTCBVH.
struct BuildNode {
  std::uint32_t count; ///< inner: children; leaf: cells
  bool leaf;
};
struct BuildLeaf : BuildNode {
  std::uint32_t cells[most_leaf_cells]; ///< flat ids
};
struct BuildInner : BuildNode {
  BuildNode* child[8];
  Box box[8]; ///< of the children
};

/// Builds 8-wide over the primitives, which the build reorders. fast: in Morton order; otherwise by
/// binned surface area. Throws core::Error.
const BuildNode* build(const Device& device, RTCBVH bvh, RTCBuildPrimitive* primitives,
                       std::size_t count, bool fast);

} // namespace insitu::accel::embree
