#include "scene/output_times.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace insitu::scene {

std::vector<DueTime> OutputClock::due(double time) const {
  std::vector<DueTime> found;
  const double begin = state_.begun ? state_.first : time;
  if (!times_.at.empty()) {
    for (auto k = std::size_t(state_.count); k < times_.at.size() && times_.at[k] <= time; ++k)
      if (times_.at[k] >= begin)
        found.push_back({times_.at[k], std::int64_t(k)});
    if (found.size() > std::size_t(most_times))
      refuse_times("times", double(found.size()), time);
  } else if (times_.interval) {
    const double from = times_.from.value_or(begin), interval = *times_.interval;
    const double last =
        std::min(time, times_.until.value_or(std::numeric_limits<double>::infinity()));
    // Those before the first execution are passed over.
    const double skipped =
        state_.begun ? 0.0 : std::max(0.0, std::floor((begin - from) / interval) - 1.0);
    found = even_times("times", from, interval,
                       std::max(state_.count, std::int64_t(std::min(skipped, 9e18))), last);
    std::erase_if(found, [&](const DueTime& due) { return due.time < begin; });
  }
  return found;
}

void OutputClock::note(double time, const std::vector<DueTime>& due) {
  state_.note(time, due.empty() ? state_.count : due.back().number + 1);
}

} // namespace insitu::scene
