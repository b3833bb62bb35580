#pragma once

#include <cstdint>
#include <openvkl/openvkl.h>
#include <openvkl/version.h>
#include <utility>
#include <vector>

#include "workload/mesh.h"

/// What all uses of Open VKL share; included by openvkl_*.cpp alone.
namespace insitu::bench {

/// One for the program's life: devices start threads and load modules. The first call says on how
/// many threads it builds. Throws std::runtime_error.
VKLDevice openvkl_device(int threads = 1);
/// Throws std::runtime_error with what the device has to say, if anything.
void throw_openvkl_error();

/// Samplers and contexts as its calls take them: handles are pointers before 2.0, and objects that
/// are passed by their address from then on.
#if OPENVKL_VERSION_MAJOR >= 2
template <class Handle>
Handle* passed(Handle& handle) {
  return &handle;
}
#else
template <class Handle>
Handle passed(Handle handle) {
  return handle;
}
#endif

/// A handle that is released when it goes.
template <class Handle>
class OpenVkl {
public:
  OpenVkl() = default;
  explicit OpenVkl(Handle handle) : handle_(handle), is_held_(true) {}
  ~OpenVkl() { reset(); }
  OpenVkl(OpenVkl&& other) noexcept { swap(other); }
  OpenVkl& operator=(OpenVkl&& other) noexcept {
    reset();
    swap(other);
    return *this;
  }
  void reset() {
    if (std::exchange(is_held_, false))
      vklRelease(handle_);
  }
  Handle& operator*() { return handle_; }

private:
  void swap(OpenVkl& other) {
    std::swap(handle_, other.handle_);
    std::swap(is_held_, other.is_held_);
  }
  Handle handle_{};
  bool is_held_ = false;
};

/// Of an array that outlives the object.
template <class Object, class T>
void set_shared(Object object, const char* name, const std::vector<T>& items, VKLDataType type) {
  OpenVkl<VKLData> data(
      vklNewData(openvkl_device(), items.size(), type, items.data(), VKL_DATA_SHARED_BUFFER, 0));
  vklSetData(object, name, *data);
}

/// The unstructured volume of a mesh with its arrays in float, and a sampler of it; NaN outside of
/// cells.
class OpenVklMesh {
public:
  OpenVklMesh(const workload::Mesh& mesh, const std::vector<double>& field);

  /// Builds anew.
  void build();
  VKLSampler& sampler() { return *sampler_; }

private:
  std::vector<vkl_vec3f> points_;
  std::vector<float> field_;
  std::vector<std::uint32_t> index_, first_;
  std::vector<std::uint8_t> types_;
  OpenVkl<VKLVolume> volume_;
  OpenVkl<VKLSampler> sampler_;
};

} // namespace insitu::bench
