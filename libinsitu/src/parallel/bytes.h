#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
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
    array(std::span<const T>(&v, 1));
  }
  /// Its items alone, not how many there are.
  template <class T>
  void array(std::span<const T> items) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::span<const std::byte> bytes = std::as_bytes(items);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  bool empty() const { return bytes_.empty(); }
  std::size_t size() const { return bytes_.size(); }
  std::vector<std::byte> take() { return std::move(bytes_); }

private:
  std::vector<std::byte> bytes_;
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
      throw core::Error(INSITU_ERROR_INTERNAL,
                        "a parcel is too short: " + std::to_string(rest_.size()) + " bytes left, " +
                            std::to_string(bytes) + " expected");
    if (bytes > 0)
      std::memcpy(static_cast<void*>(items.data()), rest_.data(), bytes);
    rest_ = rest_.subspan(bytes);
  }
  template <class T>
  std::vector<T> array(std::size_t count) {
    if (count > rest_.size() / sizeof(T)) // before memory is taken
      throw core::Error(INSITU_ERROR_INTERNAL,
                        "a parcel is too short: " + std::to_string(rest_.size()) + " bytes left, " +
                            std::to_string(count) + " items expected");
    std::vector<T> items(count);
    array(std::span<T>(items));
    return items;
  }
  bool at_end() const { return rest_.empty(); }
  std::size_t left() const { return rest_.size(); }

private:
  std::span<const std::byte> rest_;
};

} // namespace insitu::parallel
