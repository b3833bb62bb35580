#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

#include "insitu/insitu.h"

namespace insitu::core {

/// Returns the name of a purpose in files and messages, such as "tree", and "unknown" for any other
/// number.
const char* purpose_name(insitu_purpose purpose);

/// Counts the bytes that a session holds, by purpose. Thread-safe.
class Memory {
public:
  void add(insitu_purpose purpose, std::int64_t bytes);
  std::int64_t current() const { return total_.load(std::memory_order_relaxed); }
  std::int64_t current(insitu_purpose purpose) const {
    return by_purpose_[purpose].load(std::memory_order_relaxed);
  }
  std::int64_t peak() const { return peak_.load(std::memory_order_relaxed); }
  /// Makes the current use the peak.
  void reset_peak() { peak_.store(current()); }

private:
  std::atomic<std::int64_t> total_{0};
  std::atomic<std::int64_t> peak_{0};
  std::atomic<std::int64_t> by_purpose_[INSITU_MEMORY_COUNT]{};
};

/// Allocates memory that is aligned to 64 bytes, in huge pages where it is large. Throws
/// Error(INSITU_ERROR_MEMORY).
void* allocate_bytes(std::size_t bytes);
void free_bytes(void* p) noexcept;

/// A Buffer holds counted, uninitialised memory of a trivial type, and keeps it for reuse: resizing
/// to a smaller or equal size never allocates, since the page faults of first touches cost more
/// than the work itself.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

public:
  Buffer(Memory& memory, insitu_purpose purpose) : memory_(&memory), purpose_(purpose) {}
  Buffer(Buffer&& b) noexcept
      : memory_(b.memory_), purpose_(b.purpose_), data_(std::exchange(b.data_, nullptr)),
        size_(std::exchange(b.size_, 0)), capacity_(std::exchange(b.capacity_, 0)) {}
  Buffer& operator=(Buffer&& b) noexcept {
    if (this != &b) {
      release();
      memory_ = b.memory_;
      purpose_ = b.purpose_;
      data_ = std::exchange(b.data_, nullptr);
      size_ = std::exchange(b.size_, 0);
      capacity_ = std::exchange(b.capacity_, 0);
    }
    return *this;
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { release(); }

  /// Changes the size. The contents are lost if memory has to grow.
  void resize_discard(std::size_t n) {
    if (n > capacity_)
      reallocate(n, false);
    size_ = n;
  }
  /// Changes the size, and keeps the first min(old, new) items.
  void resize(std::size_t n) {
    if (n > capacity_)
      reallocate(n > capacity_ + capacity_ / 2 ? n : capacity_ + capacity_ / 2, true);
    size_ = n;
  }
  void push_back(const T& value) {
    const T copy = value;
    resize(size_ + 1);
    data_[size_ - 1] = copy;
  }
  /// Gives unused capacity back to the system.
  void shrink() {
    if (capacity_ > size_)
      reallocate(size_, true);
  }
  void release() noexcept {
    if (data_) {
      free_bytes(data_);
      memory_->add(purpose_, -std::int64_t(capacity_ * sizeof(T)));
    }
    data_ = nullptr;
    size_ = capacity_ = 0;
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::size_t bytes() const { return capacity_ * sizeof(T); }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  std::span<T> span() { return {data_, size_}; }
  std::span<const T> span() const { return {data_, size_}; }

private:
  void reallocate(std::size_t n, bool keep) {
    if (n == 0) {
      release();
      return;
    }
    if (!keep) {
      const std::size_t kept_size = size_;
      release();
      size_ = kept_size;
    }
    T* fresh = static_cast<T*>(allocate_bytes(n * sizeof(T)));
    if (keep && data_ && size_)
      std::memcpy(static_cast<void*>(fresh), data_, (size_ < n ? size_ : n) * sizeof(T));
    const std::size_t size = size_;
    memory_->add(purpose_, std::int64_t(n * sizeof(T)));
    if (keep)
      release();
    data_ = fresh;
    capacity_ = n;
    size_ = size;
  }

  Memory* memory_;
  insitu_purpose purpose_;
  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

} // namespace insitu::core
