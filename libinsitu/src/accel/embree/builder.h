#pragma once

#include <cstdint>

#include "accel/embree/device.h"
#include "accel/tree/node.h"

namespace insitu::accel::embree {

/// A node of Embree's build, in memory of the RTCBVH. Its children are nodes, or, at the bottom,
/// single cells: what Embree takes for a leaf of up to eight cells is a node here.
struct BuildNode {
  std::uint32_t count = 0; ///< of children
  bool bottom = false;
  std::uint8_t single = 0; ///< bit i: child i is a bottom node of one cell
  union {
    BuildNode* child[8];
    std::uint32_t cell[8]; ///< flat ids
  };
  Box box[8]; ///< of the children
};

/// Builds 8-wide, by binned surface area, over the primitives, which the build reorders. Throws
/// core::Error.
const BuildNode* build(const Device& device, RTCBVH bvh, RTCBuildPrimitive* primitives,
                       std::size_t count);

} // namespace insitu::accel::embree
