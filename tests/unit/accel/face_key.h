#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "accel/locator.h"

namespace insitu::test {

/// Sorted, and a quad's corner opposite to the lowest; none behind triangles.
using Key = std::array<std::uint32_t, 5>;

inline bool key_of(std::vector<std::uint32_t> cycle, Key& key) {
  cycle.erase(std::unique(cycle.begin(), cycle.end()), cycle.end());
  while (cycle.size() > 1 && cycle.front() == cycle.back())
    cycle.pop_back();
  if (cycle.size() < 3 || (cycle.size() == 4 && (cycle[0] == cycle[2] || cycle[1] == cycle[3])))
    return false;
  key.fill(accel::none);
  const auto low = std::size_t(std::min_element(cycle.begin(), cycle.end()) - cycle.begin());
  if (cycle.size() == 4)
    key[4] = cycle[(low + 2) % 4];
  std::sort(cycle.begin(), cycle.end());
  std::copy(cycle.begin(), cycle.end(), key.begin());
  return true;
}

} // namespace insitu::test
