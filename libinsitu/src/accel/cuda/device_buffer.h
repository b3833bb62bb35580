#pragma once

#include <cstddef>
#include <cstdint>
#include <cuda_runtime_api.h>
#include <type_traits>
#include <utility>

#include "core/memory.h"

/// Counted memory on the device and pinned memory on the host. For files of the CUDA and OptiX
/// backends alone.
namespace insitu::accel::cuda {

/// Throws core::Error if a call failed: INSITU_ERROR_MEMORY with the device's free and total bytes
/// if it ran out of memory, else INSITU_ERROR_UNSUPPORTED. what: what was being done, such as
/// "copying points".
void check(cudaError_t status, const char* what);
/// The same for the last launch of a kernel.
inline void check_launch(const char* what) {
  check(cudaGetLastError(), what);
}

void* allocate_device(std::size_t bytes);
void free_device(void* p) noexcept;
void* allocate_pinned(std::size_t bytes);
void free_pinned(void* p) noexcept;

/// Counted memory of a trivial type, on the device or pinned on the host, kept and reused: it grows
/// and never shrinks unless released. Contents are lost when it grows.
template <class T, bool on_device>
class CountedBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

public:
  explicit CountedBuffer(core::Memory& memory, insitu_purpose purpose = on_device
                                                                            ? INSITU_MEMORY_DEVICE
                                                                            : INSITU_MEMORY_QUERY)
      : memory_(&memory), purpose_(purpose) {}
  CountedBuffer(CountedBuffer&& b) noexcept
      : memory_(b.memory_), purpose_(b.purpose_), data_(std::exchange(b.data_, nullptr)),
        size_(std::exchange(b.size_, 0)), capacity_(std::exchange(b.capacity_, 0)) {}
  CountedBuffer& operator=(CountedBuffer&& b) noexcept {
    std::swap(memory_, b.memory_);
    std::swap(purpose_, b.purpose_);
    std::swap(data_, b.data_);
    std::swap(size_, b.size_);
    std::swap(capacity_, b.capacity_);
    return *this;
  }
  ~CountedBuffer() { release(); }

  void resize_discard(std::size_t n) {
    if (n > capacity_) {
      release();
      data_ = static_cast<T*>(on_device ? allocate_device(n * sizeof(T))
                                        : allocate_pinned(n * sizeof(T)));
      memory_->add(purpose_, std::int64_t(n * sizeof(T)));
      capacity_ = n;
    }
    size_ = n;
  }
  void release() noexcept {
    if (data_) {
      on_device ? free_device(data_) : free_pinned(data_);
      memory_->add(purpose_, -std::int64_t(capacity_ * sizeof(T)));
    }
    data_ = nullptr;
    size_ = capacity_ = 0;
  }

  T* data() const { return data_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::int64_t bytes() const { return std::int64_t(capacity_ * sizeof(T)); }
  T& operator[](std::size_t i) const // of pinned memory
      requires(!on_device) {
    return data_[i];
  }

private:
  core::Memory* memory_;
  insitu_purpose purpose_;
  T* data_ = nullptr;
  std::size_t size_ = 0, capacity_ = 0;
};

template <class T>
using DeviceBuffer = CountedBuffer<T, true>;
template <class T>
using PinnedBuffer = CountedBuffer<T, false>;

/// A stream that waits for no other; the owner orders it with events or waits.
class Stream {
public:
  Stream();
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  cudaStream_t get() const { return stream_; }
  void wait(const char* what) const { check(cudaStreamSynchronize(stream_), what); }

private:
  cudaStream_t stream_ = nullptr;
};

} // namespace insitu::accel::cuda
