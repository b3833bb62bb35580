#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace insitu::query {

/// Calls f(k) for every set bit k.
template <class F>
void for_each_bit(std::uint64_t bits, F&& f) {
  for (; bits; bits &= bits - 1)
    f(std::countr_zero(bits));
}

using BitTable = std::array<std::array<std::uint8_t, 8>, 256>;

/// set_bits[m][i]: the place of the i-th set bit of m; 0 beyond the last.
inline constexpr BitTable set_bits = [] {
  BitTable table{};
  for (unsigned m = 0; m < 256; ++m)
    for (unsigned bit = 0, i = 0; bit < 8; ++bit)
      if ((m >> bit) & 1)
        table[m][i++] = std::uint8_t(bit);
  return table;
}();

/// The same as places of bytes for items of two.
inline constexpr auto set_bit_pairs = [] {
  struct alignas(16) Row {
    std::uint8_t byte[16];
  };
  std::array<Row, 256> table{};
  for (std::size_t m = 0; m < 256; ++m)
    for (std::size_t i = 0; i < 8; ++i) {
      table[m].byte[2 * i] = std::uint8_t(2 * set_bits[m][i]);
      table[m].byte[2 * i + 1] = std::uint8_t(2 * set_bits[m][i] + 1);
    }
  return table;
}();

/// bits_below[m][c]: how many bits of m are set below bit c.
inline constexpr BitTable bits_below = [] {
  BitTable table{};
  for (unsigned m = 0; m < 256; ++m)
    for (unsigned c = 1; c < 8; ++c)
      table[m][c] = std::uint8_t(table[m][c - 1] + ((m >> (c - 1)) & 1));
  return table;
}();

} // namespace insitu::query
