#include "accel/embree/builder.h"

#include <new>

namespace insitu::accel::embree {

namespace {

void* create_inner(RTCThreadLocalAllocator allocator, unsigned count, void*) {
  auto* node = new (rtcThreadLocalAlloc(allocator, sizeof(BuildInner), 16)) BuildInner;
  node->count = count;
  node->leaf = false;
  return static_cast<BuildNode*>(node);
}

void set_children(void* pointer, void** children, unsigned count, void*) {
  auto* node = static_cast<BuildInner*>(static_cast<BuildNode*>(pointer));
  node->count = count;
  for (unsigned i = 0; i < count; ++i)
    node->child[i] = static_cast<BuildNode*>(children[i]);
}

void set_bounds(void* pointer, const RTCBounds** bounds, unsigned count, void*) {
  auto* node = static_cast<BuildInner*>(static_cast<BuildNode*>(pointer));
  for (unsigned i = 0; i < count; ++i)
    node->box[i] = {{bounds[i]->lower_x, bounds[i]->lower_y, bounds[i]->lower_z},
                    {bounds[i]->upper_x, bounds[i]->upper_y, bounds[i]->upper_z}};
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives,
                  std::size_t count, void*) {
  auto* node = new (rtcThreadLocalAlloc(allocator, sizeof(BuildLeaf), 16)) BuildLeaf;
  node->count = unsigned(count);
  node->leaf = true;
  for (std::size_t i = 0; i < count; ++i)
    node->cells[i] = primitives[i].primID;
  return static_cast<BuildNode*>(node);
}

} // namespace

const BuildNode* build(const Device& device, RTCBVH bvh, RTCBuildPrimitive* primitives,
                       std::size_t count, bool fast) {
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.byteSize = sizeof arguments;
  arguments.buildQuality = fast ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = 8;
  arguments.maxDepth = 48;
  arguments.sahBlockSize = 1;
  arguments.minLeafSize = 1;
  arguments.maxLeafSize = most_leaf_cells;
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
