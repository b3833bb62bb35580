#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "query/location.h"

namespace insitu::query {

/// How many points were located for which reason. Thread-safe.
class LocateCounts {
public:
  void add(const std::int64_t (&by_reason)[reason_count]);
  void add(Reason reason);
  std::array<std::int64_t, reason_count> totals() const;

  /// Points, among those counted, that particles asked for because no neighbour was known of the
  /// cell that they were in; see CommittedMesh::find_neighbours_if_due().
  void add_unguided(std::int64_t points) { unguided_.fetch_add(points, std::memory_order_relaxed); }
  std::int64_t unguided() const { return unguided_.load(std::memory_order_relaxed); }

private:
  /// A few copies, a cache line each, so that threads do not wait for each other.
  struct alignas(64) Copy {
    std::atomic<std::int64_t> by_reason[reason_count] = {};
  };
  static constexpr std::size_t copy_count = 16;
  Copy& mine();
  Copy copies_[copy_count];
  std::atomic<std::int64_t> unguided_{0};
};

/// How batches by a ray method were answered, in points; not those in `fast`, which proves nothing.
/// Thread-safe.
struct RayCounts {
  std::atomic<std::int64_t> kept{0};         ///< the cell that the rays told, proven
  std::atomic<std::int64_t> by_neighbour{0}; ///< the cell beyond the face that was hit, proven
  std::atomic<std::int64_t> by_tree{0};      ///< through the tree, outside ones included
};

} // namespace insitu::query
