#include "query/batch/device_calls.h"

#include <algorithm>
#include <vector>

namespace insitu::query {

using math::Vec3d;

/// The device answers slices, which are given on in parallel.
bool DeviceCalls::visit(const core::Threads& threads, std::span<const Vec3d> points,
                        const LocateOptions& options, LocateCounts* counts, PutAnswers put) const {
  if (options.alpha != 1.0)
    return false;
  constexpr std::size_t slice = std::size_t(1) << 20;
  const std::size_t most = std::min(slice, points.size());
  std::vector<std::int64_t> cells(most);
  std::vector<Vec3d> parametric(most);
  std::vector<std::uint8_t> reasons(most);
  for (std::size_t from = 0; from < points.size(); from += slice) {
    const std::size_t n = std::min(slice, points.size() - from);
    DeviceQuery query;
    query.points = &points[from].x;
    query.count = std::int64_t(n);
    query.accuracy = options.accuracy;
    query.cells = cells.data();
    query.parametric = &parametric.data()->x;
    query.reasons = reasons.data();
    note_(device_.locate(query));
    threads.parallel_for(std::int64_t(n), std::int64_t(batch_size),
                         [&](std::int64_t begin, std::int64_t end) {
                           Location locations[batch_size];
                           Reason why[batch_size];
                           std::int64_t by_reason[reason_count] = {};
                           const auto first = std::size_t(begin), count = std::size_t(end - begin);
                           for (std::size_t k = 0; k < count; ++k) {
                             locations[k] = {cells[first + k], parametric[first + k]};
                             why[k] = Reason(reasons[first + k]);
                             ++by_reason[reasons[first + k]];
                           }
                           if (counts)
                             counts->add(by_reason);
                           put({{locations, count}, {why, count}, from + first, nullptr});
                         });
  }
  return true;
}

} // namespace insitu::query
