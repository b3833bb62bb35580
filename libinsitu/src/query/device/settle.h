#pragma once

#include <mutex>

#include "query/device/locate.h"
#include "query/device/locate_kernels.h"

/// Slices of a query in flight, and what the device leaves of them to the host.
namespace insitu::query::on_device {

using device::Buffer;
using device::PinnedBuffer;

constexpr std::uint32_t pair_room = 1u << 20; ///< undecided pairs of a round

inline void copy_to_host(void* to, const void* from, std::size_t bytes, StreamHandle stream) {
  device::copy_to_host(to, from, bytes, stream, "copying answers");
}
inline void copy_to_device(void* to, const void* from, std::size_t bytes, StreamHandle stream) {
  device::copy_to_device(to, from, bytes, stream, "copying points");
}

/// Lists of one slice in flight.
struct SliceLists {
  explicit SliceLists(core::Memory& memory)
      : counters(memory), open(memory), pairs(memory),
        left(memory), again{Buffer<std::uint32_t>(memory), Buffer<std::uint32_t>(memory)},
        hard(memory), counted(memory) {}
  void make_room(std::uint32_t points) {
    counters.resize_discard(Lists::counter_count);
    counted.resize_discard(Lists::counter_count);
    open.resize_discard(points);
    pairs.resize_discard(pair_room);
    left.resize_discard(pair_room);
    again[0].resize_discard(points);
    again[1].resize_discard(points);
    hard.resize_discard(points);
  }
  Lists view(int round) const {
    Lists lists;
    lists.counters = counters.data();
    lists.open_points = open.data();
    lists.pairs = pairs.data();
    lists.left_pairs = left.data();
    lists.pair_room = pair_room;
    lists.again_points = again[round % 2].data();
    lists.hard_points = hard.data();
    return lists;
  }
  std::int64_t bytes() const {
    return counters.bytes() + open.bytes() + pairs.bytes() + left.bytes() + again[0].bytes() +
           again[1].bytes() + hard.bytes();
  }
  Buffer<std::uint32_t> counters;
  Buffer<OpenPoint> open;
  Buffer<OpenPair> pairs, left;
  Buffer<std::uint32_t> again[2];
  Buffer<OwnedPoint> hard;
  PinnedBuffer<std::uint32_t> counted;
};

/// Points and answers of one slice on their way between host and device.
struct Staging {
  explicit Staging(core::Memory& memory) : host(memory), device(memory) {}
  PinnedBuffer<std::byte> host;
  Buffer<std::byte> device;
};

struct Workspace::Impl {
  explicit Impl(core::Memory& memory)
      : lists{SliceLists(memory), SliceLists(memory)}, staging{Staging(memory), Staging(memory)},
        pair_data(memory), pair_host(memory), decided(memory), decided_host(memory),
        parametric(memory), parametric_host(memory) {}

  std::mutex mutex;
  device::Stream streams[2];
  SliceLists lists[2];
  Staging staging[2];
  Buffer<PairData> pair_data;
  PinnedBuffer<PairData> pair_host;
  Buffer<cells::Decision> decided;
  PinnedBuffer<cells::Decision> decided_host;
  Buffer<math::Vec3d> parametric;
  PinnedBuffer<math::Vec3d> parametric_host;
};

/// A slice that has been queued.
struct InFlight {
  LocateArguments arguments;
  StreamHandle stream;
  SliceLists* lists;
};

/// Waits for a slice and settles what is left of it.
void settle_slice(Workspace::Impl& work, const core::Threads& threads, InFlight& slice,
                  DeviceCounts& counts);

} // namespace insitu::query::on_device
