#pragma once

#include <cstddef>

#include "core/counted_vector.h"

namespace insitu::core {

/// Pixels in linear RGB with straight alpha, row 0 at the top, 4 floats a pixel.
struct Image {
  static constexpr std::size_t bytes_a_pixel = 4 * sizeof(float);

  int width = 0;
  int height = 0;
  CountedVector<float> rgba;

  Image() = default;
  /// Counted, if the allocator counts.
  Image(int w, int h, const CountedAllocator<float>& allocator = {})
      : width(w), height(h), rgba(std::size_t(w) * std::size_t(h) * 4, 0.0f, allocator) {}
  float* pixel(int x, int y) {
    return &rgba[(std::size_t(y) * std::size_t(width) + std::size_t(x)) * 4];
  }
  const float* pixel(int x, int y) const {
    return &rgba[(std::size_t(y) * std::size_t(width) + std::size_t(x)) * 4];
  }
};

} // namespace insitu::core
