#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "parallel/bytes.h"
#include "parallel/world.h"

namespace insitu::render {

using parallel::ByteReader;
using parallel::ByteWriter;

/// Bytes about a tile, whose number in its group is `slot`, to or from a process.
struct TileParcel {
  int rank;
  std::uint32_t slot;
  std::vector<std::byte> bytes;
  ByteReader reader() const { return ByteReader(bytes); }
};

/// Sends parcels about tiles. What a process has for itself does not pass through the World.
class TileMail {
public:
  TileMail(parallel::World& world, std::size_t most_bytes)
      : world_(world), most_bytes_(most_bytes) {}

  /// Sends all at once. Collective.
  std::vector<TileParcel> exchange(std::vector<TileParcel> parcels);
  /// Sends about most_bytes at a time: take(received) is called within an agreement, as often as it
  /// takes. Collective.
  void exchange_in_turns(std::vector<TileParcel> parcels,
                         core::FunctionRef<void(const std::vector<TileParcel>&)> take);

  /// To other processes.
  std::int64_t bytes_sent() const { return bytes_sent_; }
  std::int64_t parcels_sent() const { return parcels_sent_; }
  std::int64_t exchanges() const { return exchanges_; }

private:
  parallel::World& world_;
  std::size_t most_bytes_;
  std::int64_t bytes_sent_ = 0, parcels_sent_ = 0, exchanges_ = 0;
};

} // namespace insitu::render
