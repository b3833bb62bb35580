#include "query/locate_counts.h"

namespace insitu::query {

LocateCounts::Copy& LocateCounts::mine() {
  static std::atomic<unsigned> threads{0};
  thread_local const unsigned thread = threads.fetch_add(1, std::memory_order_relaxed);
  return copies_[thread % copy_count];
}

void LocateCounts::add(const std::int64_t (&by_reason)[reason_count]) {
  Copy& copy = mine();
  for (int i = 0; i < reason_count; ++i)
    if (by_reason[i])
      copy.by_reason[i].fetch_add(by_reason[i], std::memory_order_relaxed);
}

void LocateCounts::add(Reason reason) {
  mine().by_reason[int(reason)].fetch_add(1, std::memory_order_relaxed);
}

std::array<std::int64_t, reason_count> LocateCounts::totals() const {
  std::array<std::int64_t, reason_count> sum{};
  for (const Copy& copy : copies_)
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum[i] += copy.by_reason[i].load(std::memory_order_relaxed);
  return sum;
}

} // namespace insitu::query
