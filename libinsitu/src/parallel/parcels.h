#pragma once

#include <vector>

#include "parallel/bytes.h"
#include "parallel/world.h"

namespace insitu::parallel {

/// What goes to each process, [rank]; none to those for whom there is nothing.
inline std::vector<Parcel> parcels_of(const std::vector<ByteWriter>& to) {
  std::vector<Parcel> parcels;
  for (std::size_t r = 0; r < to.size(); ++r)
    if (!to[r].empty())
      parcels.push_back({int(r), to[r].bytes()});
  return parcels;
}
/// The same of parcels that are one array each.
template <class Item>
std::vector<Parcel> parcels_of(const std::vector<std::vector<Item>>& to) {
  std::vector<Parcel> parcels;
  for (std::size_t r = 0; r < to.size(); ++r)
    if (!to[r].empty())
      parcels.push_back({int(r), bytes_of(to[r])});
  return parcels;
}

} // namespace insitu::parallel
