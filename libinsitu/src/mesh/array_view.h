#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "insitu/insitu.h"

#include "math/hd.h"
#include "math/vec.h"

namespace insitu::mesh {

/// Where item `id` of an external array lies: bytes from the base. One stride if the items are
/// evenly spaced (`linear`), otherwise three strides over extents, first index fastest.
struct ItemLayout {
  std::int64_t count = 0;
  std::int64_t extent[2] = {0, 0};
  std::int64_t stride[3] = {0, 0, 0};
  bool linear = true;

  INSITU_HD std::int64_t offset(std::int64_t id) const {
    if (linear)
      return id * stride[0];
    const std::int64_t row = id / extent[0];
    return (id - row * extent[0]) * stride[0] + (row % extent[1]) * stride[1] +
           (row / extent[1]) * stride[2];
  }
};

#if defined(__CUDACC__)
/// Byte by byte; rare, and kept out of the kernels' loops.
template <class T>
__device__ __noinline__ T load_unaligned(const std::byte* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}
#endif

/// Unaligned read of a scalar: solvers may pack records, so strides need not be multiples of it.
template <class T>
INSITU_HD inline T load_as(const std::byte* p) {
#if defined(__CUDA_ARCH__)
  return reinterpret_cast<std::uintptr_t>(p) % sizeof(T) == 0 ? *reinterpret_cast<const T*>(p)
                                                              : load_unaligned<T>(p);
#else
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
#endif
}

/// float32 or float64 at p, as double.
INSITU_HD inline double load_real(const std::byte* p, bool is_float32) {
  return is_float32 ? double(load_as<float>(p)) : load_as<double>(p);
}

/// int32 or int64 at p.
INSITU_HD inline std::int64_t load_index(const std::byte* p, bool is_int32) {
  return is_int32 ? std::int64_t(load_as<std::int32_t>(p)) : load_as<std::int64_t>(p);
}

/// An index counted from `base`, counted from 0. Wraps around, so that garbage stays out of range.
INSITU_HD inline std::int64_t from_base(std::int64_t index, std::int64_t base) {
  return std::int64_t(std::uint64_t(index) - std::uint64_t(base));
}

/// Three real components of equal layout: vertex coordinates.
struct PointsView {
  const std::byte* component[3] = {nullptr, nullptr, nullptr};
  ItemLayout layout;
  bool is_float32 = false;

  INSITU_HD math::Vec3d load(std::int64_t id) const { return at(layout.offset(id)); }
  /// At an offset of `layout`.
  INSITU_HD math::Vec3d at(std::int64_t o) const {
    return {load_real(component[0] + o, is_float32), load_real(component[1] + o, is_float32),
            load_real(component[2] + o, is_float32)};
  }
};

/// One-dimensional indices (connectivity, offsets) with a base already subtracted on load.
struct IndexView {
  const std::byte* data = nullptr;
  std::int64_t count = 0;
  std::int64_t stride = 0;
  bool is_int32 = true;

  INSITU_HD std::int64_t load(std::int64_t i) const {
    return load_index(data + i * stride, is_int32);
  }
};

} // namespace insitu::mesh
