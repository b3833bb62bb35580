#include "accel/optix/structure.h"

#include <algorithm>
#include <cstring>
#include <optix_stubs.h>

#include "accel/optix/context.h"
#include "core/status.h"

namespace insitu::accel::optix {
namespace {

static_assert(sizeof(Box) == sizeof(OptixAabb));

CUdeviceptr address(const void* p) {
  return reinterpret_cast<CUdeviceptr>(p);
}

OptixAccelBuildOptions build_options(OptixBuildOperation operation) {
  OptixAccelBuildOptions options{};
  options.buildFlags = OPTIX_BUILD_FLAG_ALLOW_COMPACTION | OPTIX_BUILD_FLAG_ALLOW_UPDATE |
                       OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
  options.operation = operation;
  return options;
}

} // namespace

/// Holds what the driver's description points to, so it stays where it is.
struct Structure::Input {
  CUdeviceptr data = 0; ///< vertices or boxes
  unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
  OptixBuildInput input{};

  Input(const Primitives& p, const Group& group, const Box* boxes) {
    if (p.boxes) {
      data = address(boxes);
      input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
      OptixBuildInputCustomPrimitiveArray& a = input.customPrimitiveArray;
      a.aabbBuffers = &data;
      a.numPrimitives = unsigned(group.count);
      a.strideInBytes = sizeof(Box);
      a.flags = &flags;
      a.numSbtRecords = 1;
      a.primitiveIndexOffset = unsigned(group.first);
      return;
    }
    data = address(p.vertices);
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& a = input.triangleArray;
    a.vertexBuffers = &data;
    a.numVertices = unsigned(p.vertex_count);
    a.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    a.vertexStrideInBytes = 3 * sizeof(float);
    a.indexBuffer = address(p.triangles + group.first);
    a.numIndexTriplets = unsigned(group.count);
    a.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    a.indexStrideInBytes = sizeof(FaceTriangle);
    a.flags = &flags;
    a.numSbtRecords = 1;
    a.primitiveIndexOffset = unsigned(group.first);
  }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
};

Structure::Structure(core::Memory& memory, std::int64_t group)
    : memory_(&memory), group_(group), instances_(memory), top_(memory), output_(memory),
      temporary_(memory), boxes_(memory), size_(memory) {}

void Structure::clear() {
  groups_.clear();
  handle_ = 0;
  count_ = 0;
  peak_bytes_ = 0;
  top_.release();
  instances_.release();
  output_.release();
  temporary_.release();
  boxes_.release();
}

std::int64_t Structure::bytes() const {
  std::int64_t sum = instances_.bytes() + top_.bytes() + output_.bytes() + temporary_.bytes() +
                     boxes_.bytes() + size_.bytes();
  for (const Group& group : groups_)
    sum += group.memory.bytes();
  return sum;
}

void Structure::note_peak() {
  peak_bytes_ = std::max(peak_bytes_, bytes());
}

void Structure::build(const Primitives& primitives, device::StreamHandle stream) {
  clear();
  const std::int64_t most = Context::get().most_primitives();
  const std::int64_t group = std::clamp<std::int64_t>(group_, 1, most);
  if (primitives.count == 0)
    return;
  try {
    for (std::int64_t first = 0; first < primitives.count; first += group) {
      const std::int64_t n = std::min(group, primitives.count - first);
      groups_.push_back({first, n, device::Buffer<std::byte>(*memory_), 0});
      build_group(primitives, groups_.back(), stream);
    }
    output_.release();
    if (two_level())
      build_top(stream);
    else
      handle_ = groups_[0].handle;
    device::wait(stream, "building the structure of the rays");
  } catch (...) {
    clear();
    throw;
  }
  temporary_.release();
  boxes_.release();
  count_ = primitives.count;
}

void Structure::build_group(const Primitives& primitives, Group& group,
                            device::StreamHandle stream) {
  OptixDeviceContext context = Context::get().handle();
  if (primitives.boxes) {
    boxes_.resize_discard(std::size_t(group.count));
    (*primitives.boxes)(boxes_.data(), group.first, group.count);
  }
  const Input input(primitives, group, boxes_.data());
  const OptixAccelBuildOptions options = build_options(OPTIX_BUILD_OPERATION_BUILD);
  OptixAccelBufferSizes sizes{};
  check(optixAccelComputeMemoryUsage(context, &options, &input.input, 1, &sizes),
        "asking for the size of a structure");
  output_.resize_discard(sizes.outputSizeInBytes);
  temporary_.resize_discard(sizes.tempSizeInBytes);
  size_.resize_discard(1);
  note_peak();

  OptixAccelEmitDesc compacted{};
  compacted.type = OPTIX_PROPERTY_TYPE_COMPACTED_SIZE;
  compacted.result = address(size_.data());
  OptixTraversableHandle loose = 0;
  check(optixAccelBuild(context, stream, &options, &input.input, 1, address(temporary_.data()),
                        sizes.tempSizeInBytes, address(output_.data()), sizes.outputSizeInBytes,
                        &loose, &compacted, 1),
        "building a structure of " + std::to_string(group.count) + " primitives");
  std::uint64_t size = 0;
  device::copy_to_host(&size, size_.data(), sizeof size, stream, "reading the size of a structure");
  device::wait(stream, "building a structure");
  group.memory.resize_discard(size);
  note_peak();
  check(
      optixAccelCompact(context, stream, loose, address(group.memory.data()), size, &group.handle),
      "compacting a structure");
}

void Structure::build_top(device::StreamHandle stream) {
  std::vector<OptixInstance> instances(groups_.size());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    OptixInstance& instance = instances[g];
    instance = {};
    instance.transform[0] = instance.transform[5] = instance.transform[10] = 1.0f;
    instance.instanceId = unsigned(g);
    instance.visibilityMask = 255;
    instance.flags = OPTIX_INSTANCE_FLAG_NONE;
    instance.traversableHandle = groups_[g].handle;
  }
  instances_.resize_discard(instances.size());
  device::copy_to_device(instances_.data(), instances.data(),
                         instances.size() * sizeof(OptixInstance), stream, "copying instances");
  OptixBuildInput input{};
  input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
  input.instanceArray.instances = address(instances_.data());
  input.instanceArray.numInstances = unsigned(instances.size());
  OptixAccelBuildOptions options{};
  options.buildFlags = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
  options.operation = OPTIX_BUILD_OPERATION_BUILD;
  OptixDeviceContext context = Context::get().handle();
  OptixAccelBufferSizes sizes{};
  check(optixAccelComputeMemoryUsage(context, &options, &input, 1, &sizes),
        "asking for the size of the top level");
  top_.resize_discard(sizes.outputSizeInBytes);
  if (temporary_.size() < sizes.tempSizeInBytes)
    temporary_.resize_discard(sizes.tempSizeInBytes);
  note_peak();
  check(optixAccelBuild(context, stream, &options, &input, 1, address(temporary_.data()),
                        sizes.tempSizeInBytes, address(top_.data()), sizes.outputSizeInBytes,
                        &handle_, nullptr, 0),
        "building the top level over " + std::to_string(instances.size()) + " groups");
}

void Structure::refit(const Primitives& primitives, device::StreamHandle stream) {
  if (primitives.count != count_)
    throw core::Error(INSITU_ERROR_INTERNAL, "refit of " + std::to_string(primitives.count) +
                                                 " primitives in a structure of " +
                                                 std::to_string(count_));
  try {
    for (Group& group : groups_)
      refit_group(primitives, group, stream);
    if (two_level())
      build_top(stream);
    else if (count_ > 0)
      handle_ = groups_[0].handle;
    device::wait(stream, "refitting the structure of the rays");
  } catch (...) {
    clear();
    throw;
  }
}

void Structure::refit_group(const Primitives& primitives, Group& group,
                            device::StreamHandle stream) {
  OptixDeviceContext context = Context::get().handle();
  if (primitives.boxes) { // the group before is done with them, since work follows in order
    boxes_.resize_discard(std::size_t(group.count));
    (*primitives.boxes)(boxes_.data(), group.first, group.count);
  }
  const Input input(primitives, group, boxes_.data());
  const OptixAccelBuildOptions options = build_options(OPTIX_BUILD_OPERATION_UPDATE);
  OptixAccelBufferSizes sizes{};
  check(optixAccelComputeMemoryUsage(context, &options, &input.input, 1, &sizes),
        "asking for the size of a refit");
  if (temporary_.size() < sizes.tempUpdateSizeInBytes)
    temporary_.resize_discard(sizes.tempUpdateSizeInBytes);
  check(optixAccelBuild(context, stream, &options, &input.input, 1, address(temporary_.data()),
                        sizes.tempUpdateSizeInBytes, address(group.memory.data()),
                        group.memory.size(), &group.handle, nullptr, 0),
        "refitting a structure of " + std::to_string(group.count) + " primitives");
}

} // namespace insitu::accel::optix
