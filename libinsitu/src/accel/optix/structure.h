#pragma once

#include <cstdint>
#include <optix.h>
#include <vector>

#include "accel/faces/face_triangle.h"
#include "accel/tree/node.h"
#include "core/parallel.h"
#include "device/buffer.h"

namespace insitu::accel::optix {

/// What the rays of a mesh hit; pointers are the device's. Triangles, read in place, or boxes.
struct Primitives {
  std::int64_t count = 0;
  // Triangles.
  const float* vertices = nullptr; ///< [][3]
  std::int64_t vertex_count = 0;
  const FaceTriangle* triangles = nullptr;
  // Boxes: queues the computation of those of primitives [first, first + n).
  using FillBoxes = core::FunctionRef<void(Box* boxes, std::int64_t first, std::int64_t n)>;
  const FillBoxes* boxes = nullptr;
};

/// The acceleration structure of the driver over primitives, compacted. More than a group's
/// primitives are split into groups under a second level, built one after the other through the
/// same scratch, so that the most memory that a build takes is little more than what it leaves
/// (Morrical 2020, section 9.1). Programs see a primitive's number among all.
class Structure {
public:
  Structure(core::Memory& memory, std::int64_t group);

  /// Both return when done. Throw core::Error; the structure then is empty.
  void build(const Primitives& primitives, device::StreamHandle stream);
  /// The same primitives, moved: the triangles' ids and the boxes' number are as they were built.
  void refit(const Primitives& primitives, device::StreamHandle stream);

  OptixTraversableHandle handle() const { return handle_; } ///< 0: empty, rays miss
  bool two_level() const { return groups_.size() > 1; }
  std::int64_t group_count() const { return std::int64_t(groups_.size()); }
  std::int64_t count() const { return count_; }
  std::int64_t bytes() const;                             ///< held
  std::int64_t peak_bytes() const { return peak_bytes_; } ///< the most during the last build

private:
  struct Group {
    std::int64_t first, count;
    device::Buffer<std::byte> memory;
    OptixTraversableHandle handle;
  };
  struct Input; ///< of a group, as the driver wants it
  void clear();
  void build_group(const Primitives& primitives, Group& group, device::StreamHandle stream);
  void refit_group(const Primitives& primitives, Group& group, device::StreamHandle stream);
  void build_top(device::StreamHandle stream);
  void note_peak();

  core::Memory* memory_;
  std::int64_t group_;
  std::int64_t count_ = 0, peak_bytes_ = 0;
  std::vector<Group> groups_;
  OptixTraversableHandle handle_ = 0;
  device::Buffer<OptixInstance> instances_;
  device::Buffer<std::byte> top_;
  // Scratch; given back after builds, small and kept for refits.
  device::Buffer<std::byte> output_, temporary_;
  device::Buffer<Box> boxes_;
  device::Buffer<std::uint64_t> size_;
};

} // namespace insitu::accel::optix
