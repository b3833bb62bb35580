#include "render/processes/tile_mail.h"

#include <cstring>
#include <utility>

namespace insitu::render {

std::vector<TileParcel> TileMail::exchange(std::vector<TileParcel> parcels) {
  std::vector<TileParcel> received;
  std::vector<parallel::Parcel> sent;
  ++exchanges_;
  world_.agree_after([&] {
    for (TileParcel& parcel : parcels) {
      if (parcel.rank == world_.rank()) {
        received.push_back(std::move(parcel));
        continue;
      }
      // The slot stands behind the rest, where it costs no copy.
      const std::size_t size = parcel.bytes.size();
      parcel.bytes.resize(size + sizeof parcel.slot);
      std::memcpy(parcel.bytes.data() + size, &parcel.slot, sizeof parcel.slot);
      bytes_sent_ += std::int64_t(parcel.bytes.size());
      ++parcels_sent_;
      sent.push_back({parcel.rank, std::move(parcel.bytes)});
    }
  });
  if (world_.size() == 1)
    return received;
  std::vector<parallel::Parcel> arrived = world_.exchange(sent);
  world_.agree_after([&] {
    for (parallel::Parcel& parcel : arrived) {
      TileParcel& to = received.emplace_back(TileParcel{parcel.rank, 0, std::move(parcel.bytes)});
      const std::size_t size = to.bytes.size() - sizeof to.slot;
      std::memcpy(&to.slot, to.bytes.data() + size, sizeof to.slot);
      to.bytes.resize(size);
    }
  });
  return received;
}

void TileMail::exchange_in_turns(std::vector<TileParcel> parcels,
                                 core::FunctionRef<void(const std::vector<TileParcel>&)> take) {
  for (std::size_t next = 0;;) {
    std::vector<TileParcel> now;
    world_.agree_after([&] {
      for (std::size_t bytes = 0; next < parcels.size() && (now.empty() || bytes < most_bytes_);) {
        bytes += parcels[next].bytes.size();
        now.push_back(std::move(parcels[next++]));
      }
    });
    const std::vector<TileParcel> received = exchange(std::move(now));
    world_.agree_after([&] { take(received); });
    std::int64_t left = std::int64_t(parcels.size() - next);
    world_.reduce(std::span(&left, 1), parallel::Reduction::greatest);
    if (left == 0)
      return;
  }
}

} // namespace insitu::render
