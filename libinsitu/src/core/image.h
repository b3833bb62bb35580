#pragma once

#include <cstddef>
#include <vector>

namespace insitu::core {

/// Pixels in linear RGB with straight alpha, row 0 at the top, 4 floats a pixel.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> rgba;

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgba(std::size_t(w) * std::size_t(h) * 4, 0.0f) {}
  float* pixel(int x, int y) { return &rgba[(std::size_t(y) * std::size_t(width) + std::size_t(x)) * 4]; }
  const float* pixel(int x, int y) const {
    return &rgba[(std::size_t(y) * std::size_t(width) + std::size_t(x)) * 4];
  }
};

} // namespace insitu::core
