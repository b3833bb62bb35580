#pragma once

#include <vector>

#include "device/memory.h"

namespace insitu::test {

/// Device memory that holds a vector's values.
template <class T>
class OnDevice {
public:
  explicit OnDevice(std::size_t n) : data_(device::allocate(n * sizeof(T))), size_(n) {
    device::fill(data_, 0xee, n * sizeof(T), nullptr, "filling memory");
  }
  explicit OnDevice(const std::vector<T>& values) : OnDevice(values.size()) {
    device::copy_to_device(data_, values.data(), values.size() * sizeof(T), nullptr, "copying");
    device::wait(nullptr, "copying");
  }
  OnDevice(const OnDevice&) = delete;
  OnDevice& operator=(const OnDevice&) = delete;
  ~OnDevice() { device::free(data_); }
  T* data() const { return static_cast<T*>(data_); }
  std::vector<T> read() const {
    std::vector<T> out(size_);
    device::copy_to_host(out.data(), data_, size_ * sizeof(T), nullptr, "copying");
    device::wait(nullptr, "copying");
    return out;
  }

private:
  void* data_;
  std::size_t size_;
};

} // namespace insitu::test
