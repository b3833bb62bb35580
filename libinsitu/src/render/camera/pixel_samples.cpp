#include <algorithm>
#include <cstdint>
#include <numeric>

#include "render/camera/camera.h"

namespace insitu::render {

namespace {

/// Sample i of a lattice lies i / count to the right and i * generator / count below, both modulo
/// 1. Returns the least distance between samples, squared, in parts of count.
std::int64_t least_square(std::int64_t count, std::int64_t generator) {
  const auto around = [&](std::int64_t i) { return std::min(i, count - i); };
  std::int64_t least = 2 * count * count;
  for (std::int64_t i = 1; i < count; ++i) {
    const std::int64_t right = around(i), down = around(i * generator % count);
    least = std::min(least, right * right + down * down);
  }
  return least;
}

std::int64_t best_generator(std::int64_t count) {
  std::int64_t best = 1, most = 0;
  for (std::int64_t generator = 1; generator < count; ++generator) {
    if (std::gcd(generator, count) != 1)
      continue;
    const std::int64_t square = least_square(count, generator);
    if (square > most) {
      most = square;
      best = generator;
    }
  }
  return best;
}

} // namespace

std::vector<PixelOffset> pixel_samples(int count) {
  const std::int64_t generator = best_generator(count);
  // From the centre, within [-1/2, 1/2).
  const auto offset = [&](std::int64_t i) {
    return double(2 * i < count ? i : i - count) / double(count);
  };
  std::vector<PixelOffset> samples;
  for (std::int64_t i = 0; i < count; ++i)
    samples.push_back({offset(i), offset(i * generator % count)});
  return samples;
}

} // namespace insitu::render
