#include "query/device/settle.h"

#include <algorithm>
#include <vector>

#include "cells/exact/robust_inverse.h"

namespace insitu::query::on_device {

namespace {

constexpr std::uint32_t pair_slice = 1u << 15; ///< pairs at a time on the host
constexpr std::int64_t pair_grain = 64;

/// What the device leaves to the host.
class Settler {
public:
  Settler(Workspace::Impl& work, const core::Threads& threads, InFlight& slice)
      : work_(work), threads_(threads), slice_(slice), stream_(slice.stream) {}

  void run(DeviceCounts& counts) {
    wait();
    counts.candidates_kept += counted(Lists::kept);
    counts.by_tree += slice_.arguments.candidates ? counted(Lists::asked) : slice_.arguments.count;
    for (int round = 1; counted(Lists::open) > 0; ++round) {
      counts.settled_on_host += settle_open();
      const std::uint32_t again = counted(Lists::again);
      if (again == 0)
        break;
      // Once more, with the list of pairs empty. The first of them have room.
      slice_.arguments.subset = slice_.arguments.lists.again_points;
      slice_.arguments.count = again;
      slice_.arguments.lists = slice_.lists->view(round);
      const std::size_t bytes = Lists::hard * sizeof(std::uint32_t); // but those of hard points
      device::fill(slice_.lists->counters.data(), 0, bytes, stream_, "locating points");
      launch_locate(slice_.arguments, stream_);
      read_counters();
    }
    settle_hard();
  }

private:
  std::uint32_t counted(Lists::Counter c) const { return slice_.lists->counted[c]; }
  void wait() { device::wait(stream_, "locating points"); }
  void read_counters() {
    copy_to_host(slice_.lists->counted.data(), slice_.lists->counters.data(),
                 Lists::counter_count * sizeof(std::uint32_t), stream_);
    wait();
  }
  /// Brings the vertices of some pairs to the host: of open ones or hard ones.
  template <class Launch>
  const PairData* fetch(Launch launch, std::uint32_t first, std::uint32_t n) {
    work_.pair_data.resize_discard(pair_slice);
    work_.pair_host.resize_discard(pair_slice);
    launch(slice_.arguments, first, n, work_.pair_data.data(), stream_);
    copy_to_host(work_.pair_host.data(), work_.pair_data.data(), n * sizeof(PairData), stream_);
    wait();
    return work_.pair_host.data();
  }

  /// Decides the open points' pairs, exactly; the lowest id that holds a point is its owner.
  /// Returns how many points needed the host.
  std::int64_t settle_open() {
    const std::uint32_t points = counted(Lists::open), again = counted(Lists::again);
    const std::uint32_t pairs = std::min(counted(Lists::pair), pair_room);
    launch_decide_pairs(slice_.arguments, pairs, stream_);
    read_counters();
    const std::int64_t settled = settle_left(counted(Lists::left), points);
    launch_finish(slice_.arguments, points, stream_);
    read_counters(); // hard points may have come
    slice_.lists->counted[Lists::again] = again;
    return settled;
  }

  /// The pairs that the device cannot decide, by exact arithmetic.
  std::int64_t settle_left(std::uint32_t pairs, std::uint32_t points) {
    if (pairs == 0)
      return 0;
    std::vector<OpenPair> left(pairs);
    copy_to_host(left.data(), slice_.lists->left.data(), pairs * sizeof(OpenPair), stream_);
    work_.decided.resize_discard(pair_slice);
    work_.decided_host.resize_discard(pair_slice);
    for (std::uint32_t first = 0; first < pairs; first += pair_slice) {
      const std::uint32_t n = std::min(pair_slice, pairs - first);
      const PairData* data = fetch(launch_gather_left, first, n);
      threads_.parallel_for(n, pair_grain, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t k = begin; k < end; ++k)
          work_.decided_host[std::size_t(k)] = cells::decide(data[k].shape, data[k].x, data[k].p);
      });
      copy_to_device(work_.decided.data(), work_.decided_host.data(), n, stream_);
      launch_take_decided(slice_.arguments, first, n, work_.decided.data(), stream_);
    }
    wait();
    std::vector<bool> seen(points, false);
    std::int64_t settled = 0;
    for (const OpenPair& pair : left) {
      settled += !seen[pair.open];
      seen[pair.open] = true;
    }
    return settled;
  }

  /// Parametric coordinates that Newton's method did not find.
  void settle_hard() {
    const std::uint32_t total = counted(Lists::hard);
    for (std::uint32_t first = 0; first < total; first += pair_slice) {
      const std::uint32_t n = std::min(pair_slice, total - first);
      const PairData* data = fetch(launch_gather_hard, first, n);
      work_.parametric_host.resize_discard(pair_slice);
      work_.parametric.resize_discard(pair_slice);
      threads_.parallel_for(n, pair_grain, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t k = begin; k < end; ++k)
          work_.parametric_host[std::size_t(k)] =
              cells::robust_inverse(data[k].shape, data[k].x, data[k].p);
      });
      copy_to_device(work_.parametric.data(), work_.parametric_host.data(), n * sizeof(math::Vec3d),
                     stream_);
      launch_finish_at(slice_.arguments, slice_.lists->hard.data() + first, work_.parametric.data(),
                       n, stream_);
      wait();
    }
  }

  Workspace::Impl& work_;
  const core::Threads& threads_;
  InFlight& slice_;
  StreamHandle stream_;
};

} // namespace

void settle_slice(Workspace::Impl& work, const core::Threads& threads, InFlight& slice,
                  DeviceCounts& counts) {
  Settler(work, threads, slice).run(counts);
}

} // namespace insitu::query::on_device
