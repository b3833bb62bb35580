#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Codes of Morton (1966): the bits of three coordinates in turn, those of x lowest.
namespace insitu::math {

/// The low 21 bits, two zeros between neighbours.
constexpr std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

/// Bits an axis of codes of 32 bits.
constexpr int morton_axis_bits = 10;

/// spread_bits by table: half the time where codes are all that a loop makes.
inline constexpr auto spread_table = [] {
  std::array<std::uint32_t, 1 << morton_axis_bits> table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = std::uint32_t(spread_bits(i));
  return table;
}();

/// The code of a place whose coordinates are below 2^10.
constexpr std::uint32_t morton_code(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread_table[x] | spread_table[y] << 1 | spread_table[z] << 2;
}

} // namespace insitu::math
