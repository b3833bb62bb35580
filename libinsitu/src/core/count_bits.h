#pragma once

#include <cstdint>

namespace insitu::core {

/// How many bits are set; inline, where std::popcount calls a function for lack of an instruction.
inline std::uint32_t count_bits(std::uint64_t w) {
  w -= w >> 1 & 0x5555555555555555ull;
  w = (w & 0x3333333333333333ull) + (w >> 2 & 0x3333333333333333ull);
  return std::uint32_t(((w + (w >> 4)) & 0x0f0f0f0f0f0f0f0full) * 0x0101010101010101ull >> 56);
}

} // namespace insitu::core
