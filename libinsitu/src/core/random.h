#pragma once

#include <cstdint>

namespace insitu::core {

/// Steele, Lea, Flood (2014): the finaliser of SplitMix64 over state + golden gamma.
constexpr std::uint64_t splitmix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// Counter-based random bits: a function of seed, item and channel (0..7) alone.
constexpr std::uint64_t random_bits(std::uint64_t seed, std::uint64_t item, std::uint64_t channel) {
  return splitmix64(splitmix64(seed) + 8 * item + channel);
}

/// The same as a double in [0, 1), a multiple of 2^-53.
constexpr double random_unit(std::uint64_t seed, std::uint64_t item, std::uint64_t channel) {
  return double(random_bits(seed, item, channel) >> 11) * 0x1.0p-53;
}

} // namespace insitu::core
