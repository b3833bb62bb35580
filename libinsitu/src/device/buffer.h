#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "core/memory.h"
#include "device/memory.h"

/// Counted memory on the device and pinned memory on the host.
namespace insitu::device {

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
      data_ = static_cast<T*>(on_device ? allocate(n * sizeof(T)) : allocate_pinned(n * sizeof(T)));
      memory_->add(purpose_, std::int64_t(n * sizeof(T)));
      capacity_ = n;
    }
    size_ = n;
  }
  void release() noexcept {
    if (data_) {
      on_device ? device::free(data_) : free_pinned(data_);
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
using Buffer = CountedBuffer<T, true>;
template <class T>
using PinnedBuffer = CountedBuffer<T, false>;

} // namespace insitu::device
