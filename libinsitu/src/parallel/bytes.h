#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/status.h"

/// What parcels hold: numbers and arrays one after the other, as the memory of one kind of machine
/// has them. All processes of a World run the same build.
namespace insitu::parallel {

class ByteWriter {
public:
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (sizeof v > capacity_ - size_)
      grow(sizeof v);
    std::memcpy(bytes_.get() + size_, &v, sizeof v);
    size_ += sizeof v;
  }
  /// Its items alone, not how many there are.
  template <class T>
  void array(std::span<const T> items) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (items.empty())
      return;
    if (items.size_bytes() > capacity_ - size_)
      grow(items.size_bytes());
    std::memcpy(bytes_.get() + size_, items.data(), items.size_bytes());
    size_ += items.size_bytes();
  }
  void clear() { size_ = 0; }
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  /// With room for some more bytes.
  std::vector<std::byte> bytes(std::size_t room = 0) const {
    std::vector<std::byte> bytes;
    bytes.reserve(size_ + room);
    bytes.assign(bytes_.get(), bytes_.get() + size_);
    return bytes;
  }

private:
  void grow(std::size_t more) {
    const std::size_t capacity = 2 * capacity_ + more + (std::size_t(1) << 12);
    std::unique_ptr<std::byte[]> larger(new std::byte[capacity]); // not set to 0 first
    if (size_ > 0)
      std::memcpy(larger.get(), bytes_.get(), size_);
    bytes_ = std::move(larger);
    capacity_ = capacity;
  }

  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_ = 0, capacity_ = 0;
};

/// Throws core::Error (INSITU_ERROR_INTERNAL) where a parcel is shorter than what is read of it.
class ByteReader {
public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  T value() {
    T v;
    array(std::span<T>(&v, 1));
    return v;
  }
  template <class T>
  void array(std::span<T> items) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t bytes = items.size_bytes();
    if (bytes > rest_.size())
      refuse(bytes);
    if (bytes > 0)
      std::memcpy(static_cast<void*>(items.data()), rest_.data(), bytes);
    rest_ = rest_.subspan(bytes);
  }
  template <class T>
  std::vector<T> array(std::size_t count) {
    if (count > rest_.size() / sizeof(T)) // before memory is taken
      refuse(count * sizeof(T));
    std::vector<T> items(count);
    array(std::span<T>(items));
    return items;
  }
  /// Leaves out so many items.
  template <class T>
  void skip(std::size_t count) {
    if (count > rest_.size() / sizeof(T))
      refuse(count * sizeof(T));
    rest_ = rest_.subspan(count * sizeof(T));
  }
  bool at_end() const { return rest_.empty(); }
  std::size_t left() const { return rest_.size(); }

private:
  [[noreturn]] void refuse(std::size_t expected) const {
    throw core::Error(INSITU_ERROR_INTERNAL,
                      "a parcel is too short: " + std::to_string(rest_.size()) + " bytes left, " +
                          std::to_string(expected) + " expected");
  }

  std::span<const std::byte> rest_;
};

/// Of a parcel that is one array: its bytes, and back.
template <class T>
std::vector<std::byte> bytes_of(std::span<const T> items) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto bytes = std::as_bytes(items);
  return {bytes.begin(), bytes.end()};
}
template <class T>
std::vector<std::byte> bytes_of(const std::vector<T>& items) {
  return bytes_of(std::span<const T>(items));
}
template <class T>
std::vector<T> items_of(std::span<const std::byte> bytes) {
  return ByteReader(bytes).array<T>(bytes.size() / sizeof(T));
}

} // namespace insitu::parallel
