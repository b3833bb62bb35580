#pragma once

#include <bit>
#include <cstdint>

#include "core/random.h"

namespace insitu::render {

/// The random numbers of one path: a function of seed, cycle, pixel and sample alone, and as many
/// as the path asks for. Each path is a SplitMix64 generator with a start and an odd increment of
/// its own, as Steele, Lea and Flood (2014) split theirs, so that no two paths run through the same
/// numbers.
class PathRandom {
public:
  PathRandom() = default;
  PathRandom(std::uint64_t seed, std::uint64_t cycle, std::uint64_t pixel, std::uint64_t sample) {
    using core::splitmix64;
    state_ = splitmix64(splitmix64(splitmix64(splitmix64(seed) ^ cycle) ^ pixel) ^ sample);
    increment_ = splitmix64(state_) | 1;
    // Too regular bit patterns make weak increments; theirs is the remedy.
    if (std::popcount(increment_ ^ (increment_ >> 1)) < 24)
      increment_ ^= 0xaaaaaaaaaaaaaaaaull;
  }

  std::uint64_t bits() {
    state_ += increment_;
    return core::splitmix64(state_);
  }
  /// In [0, 1), a multiple of 2^-53.
  double unit() { return double(bits() >> 11) * 0x1.0p-53; }

private:
  std::uint64_t state_ = 0, increment_ = 1;
};

} // namespace insitu::render
