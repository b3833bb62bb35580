#include "accel/embree/builder.h"

#include <new>

namespace insitu::accel::embree {

namespace {

BuildNode* new_node(RTCThreadLocalAllocator allocator, std::size_t count) {
  auto* node = new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), 16)) BuildNode;
  node->count = std::uint32_t(count);
  return node;
}

void* create_inner(RTCThreadLocalAllocator allocator, unsigned count, void*) {
  return new_node(allocator, count);
}

void set_children(void* pointer, void** children, unsigned count, void*) {
  auto* node = static_cast<BuildNode*>(pointer);
  node->count = count;
  for (unsigned i = 0; i < count; ++i) {
    node->child[i] = static_cast<BuildNode*>(children[i]);
    if (node->child[i]->bottom && node->child[i]->count == 1)
      node->single |= std::uint8_t(1u << i);
  }
}

void set_bounds(void* pointer, const RTCBounds** bounds, unsigned count, void*) {
  auto* node = static_cast<BuildNode*>(pointer);
  for (unsigned i = 0; i < count; ++i)
    node->box[i] = {{bounds[i]->lower_x, bounds[i]->lower_y, bounds[i]->lower_z},
                    {bounds[i]->upper_x, bounds[i]->upper_y, bounds[i]->upper_z}};
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives,
                  std::size_t count, void*) {
  BuildNode* node = new_node(allocator, count);
  node->bottom = true;
  for (std::size_t i = 0; i < count; ++i) {
    const RTCBuildPrimitive& p = primitives[i];
    node->cell[i] = p.primID;
    node->box[i] = {{p.lower_x, p.lower_y, p.lower_z}, {p.upper_x, p.upper_y, p.upper_z}};
  }
  return node;
}

} // namespace

const BuildNode* build(const Device& device, RTCBVH bvh, RTCBuildPrimitive* primitives,
                       std::size_t count) {
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.byteSize = sizeof arguments;
  arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = 8;
  arguments.maxDepth = 48;
  // Eight cells fill a node of ours, so they cost what one does and splitting them gains nothing.
  arguments.sahBlockSize = 8;
  arguments.minLeafSize = 8;
  arguments.maxLeafSize = 8;
  arguments.traversalCost = 1.0f;
  arguments.intersectionCost = 1.0f;
  arguments.bvh = bvh;
  arguments.primitives = primitives;
  arguments.primitiveCount = count;
  arguments.primitiveArrayCapacity = count;
  arguments.createNode = create_inner;
  arguments.setNodeChildren = set_children;
  arguments.setNodeBounds = set_bounds;
  arguments.createLeaf = create_leaf;
  const auto* root = static_cast<const BuildNode*>(rtcBuildBVH(&arguments));
  device.check("building the tree");
  return root;
}

} // namespace insitu::accel::embree
