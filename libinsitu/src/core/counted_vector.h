#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

#include "core/memory.h"

namespace insitu::core {

/// Gives a standard container memory that is counted by purpose, as a Buffer's is; by default
/// nothing is counted. What is counted moves with the container and must not outlive the Memory; a
/// copy made by a constructor is not counted.
template <class T>
class CountedAllocator {
public:
  using value_type = T;
  using is_always_equal = std::false_type;
  using propagate_on_container_move_assignment = std::true_type;
  using propagate_on_container_swap = std::true_type;

  CountedAllocator() = default;
  CountedAllocator(Memory& memory, insitu_purpose purpose) : memory_(&memory), purpose_(purpose) {}
  template <class U>
  CountedAllocator(const CountedAllocator<U>& other)
      : memory_(other.memory()), purpose_(other.purpose()) {}

  T* allocate(std::size_t n) {
    T* const p = static_cast<T*>(allocate_bytes(n * sizeof(T)));
    if (memory_)
      memory_->add(purpose_, std::int64_t(n * sizeof(T)));
    return p;
  }
  void deallocate(T* p, std::size_t n) noexcept {
    free_bytes(p);
    if (memory_)
      memory_->add(purpose_, -std::int64_t(n * sizeof(T)));
  }
  CountedAllocator select_on_container_copy_construction() const { return {}; }

  Memory* memory() const { return memory_; }
  insitu_purpose purpose() const { return purpose_; }
  friend bool operator==(const CountedAllocator& a, const CountedAllocator& b) {
    return a.memory_ == b.memory_ && a.purpose_ == b.purpose_;
  }

private:
  Memory* memory_ = nullptr;
  insitu_purpose purpose_ = INSITU_MEMORY_FRAME;
};

template <class T>
using CountedVector = std::vector<T, CountedAllocator<T>>;

} // namespace insitu::core
