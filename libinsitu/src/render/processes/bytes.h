#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace insitu::render {

/// Plain values one after the other, as processes of one machine's kind send them to each other.
class ByteWriter {
public:
  void clear() { size_ = 0; }
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (size_ + sizeof value > capacity_)
      grow();
    std::memcpy(bytes_.get() + size_, &value, sizeof value);
    size_ += sizeof value;
  }
  std::size_t size() const { return size_; }
  std::vector<std::byte> bytes() const { return {bytes_.get(), bytes_.get() + size_}; }

private:
  void grow() {
    static_assert(sizeof(std::byte) == 1);
    const std::size_t capacity = 2 * capacity_ + (std::size_t(1) << 16);
    std::unique_ptr<std::byte[]> larger(new std::byte[capacity]);
    if (size_ > 0)
      std::memcpy(larger.get(), bytes_.get(), size_);
    bytes_ = std::move(larger);
    capacity_ = capacity;
  }

  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_ = 0, capacity_ = 0;
};

class ByteReader {
public:
  explicit ByteReader(std::span<const std::byte> bytes)
      : at_(bytes.data()), end_(bytes.data() + bytes.size()) {}
  bool is_done() const { return at_ == end_; }
  /// To be called for what was written alone.
  template <class T>
  T get() {
    T value;
    std::memcpy(&value, at_, sizeof value);
    at_ += sizeof value;
    return value;
  }

private:
  const std::byte *at_, *end_;
};

} // namespace insitu::render
