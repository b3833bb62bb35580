#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/processes/tile_data.h"
#include "render/structures/place_value.h"

/// What processes tell of places that may be in cells of any of them: the lowest cell's value
/// counts.
namespace insitu::render {

/// Bytes of a place's value on its way; a bit a place comes before them.
constexpr std::int64_t bytes_a_place_value = 16;
static_assert(sizeof(PlaceValue) == std::size_t(bytes_a_place_value));

/// Writes the values of places that this process's own cells hold, which of all these are. found:
/// cells are keys.
inline void write_values(std::span<const PlaceValue> found, ByteWriter& to) {
  std::vector<std::uint64_t> held(words_of(found.size()));
  for (std::size_t i = 0; i < found.size(); ++i)
    held[i / 64] |= std::uint64_t(found[i].cell >= 0) << (i % 64);
  to.array(std::span<const std::uint64_t>(held));
  for (const PlaceValue& value : found)
    if (value.cell >= 0)
      to.value(value);
}

/// Reads them into known(place), a PlaceValue &, where the cell is lower than its. asked: which
/// places the process was asked of.
template <class Known>
void read_values(ByteReader& from, std::span<const std::uint32_t> asked, Known&& known) {
  const auto held = from.array<std::uint64_t>(words_of(asked.size()));
  for (std::size_t i = 0; i < asked.size(); ++i)
    if (held[i / 64] >> (i % 64) & 1) {
      const auto value = from.value<PlaceValue>();
      if (PlaceValue& place = known(asked[i]); place.cell < 0 || value.cell < place.cell)
        place = value;
    }
}

} // namespace insitu::render
