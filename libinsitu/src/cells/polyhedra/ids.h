#pragma once

#include <cstdint>
#include <limits>

#include "core/memory.h"
#include "mesh/array_view.h"

namespace insitu::cells {

/// Indices, in 32 bits where all of them fit.
class Ids {
public:
  explicit Ids(core::Memory& memory)
      : narrow_(memory, INSITU_MEMORY_POLYHEDRA), wide_(memory, INSITU_MEMORY_POLYHEDRA) {}

  /// Makes room for so many, none above `largest`; what was there is lost.
  void resize(std::int64_t count, std::int64_t largest) {
    is_narrow_ = largest <= std::numeric_limits<std::int32_t>::max();
    narrow_.release();
    wide_.release();
    if (is_narrow_)
      narrow_.resize_discard(std::size_t(count));
    else
      wide_.resize_discard(std::size_t(count));
  }
  std::int64_t size() const { return std::int64_t(is_narrow_ ? narrow_.size() : wide_.size()); }
  std::int64_t operator[](std::int64_t i) const {
    return is_narrow_ ? narrow_[std::size_t(i)] : wide_[std::size_t(i)];
  }
  void set(std::int64_t i, std::int64_t id) {
    if (is_narrow_)
      narrow_[std::size_t(i)] = std::int32_t(id);
    else
      wide_[std::size_t(i)] = id;
  }
  const std::byte* data() const {
    return is_narrow_ ? reinterpret_cast<const std::byte*>(narrow_.data())
                      : reinterpret_cast<const std::byte*>(wide_.data());
  }
  std::int64_t item_size() const { return is_narrow_ ? 4 : 8; }
  /// Groups of so many are one item.
  mesh::IndexView view(std::int64_t group = 1) const {
    return {data(), size() / group, item_size() * group, is_narrow_};
  }
  std::int64_t bytes() const { return std::int64_t(narrow_.bytes() + wide_.bytes()); }

private:
  bool is_narrow_ = true;
  core::Buffer<std::int32_t> narrow_;
  core::Buffer<std::int64_t> wide_;
};

} // namespace insitu::cells
