#include "scene/run/output_times.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace insitu::scene {

OutputClock::OutputClock(const OutputTimes& times, OwnTime own) : times_(times), own_(own) {
  if (!own.backward())
    return;
  for (double& time : times_.at)
    time = own.of(time);
  std::reverse(times_.at.begin(), times_.at.end());
  for (std::optional<double>* end : {&times_.from, &times_.until})
    if (*end)
      *end = own.of(**end);
}

/// A list that is gone through backward has its last time first.
std::int64_t OutputClock::place(std::int64_t number) const {
  return own_.backward() && !times_.at.empty() ? std::int64_t(times_.at.size()) - 1 - number
                                               : number;
}

std::vector<DueTime> OutputClock::due(double run_time) const {
  const double time = own_.of(run_time);
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
  for (DueTime& due : found) {
    due.time = own_.of(due.time);
    due.number = place(due.number);
  }
  return found;
}

void OutputClock::note(double time, const std::vector<DueTime>& due) {
  state_.note(own_.of(time), due.empty() ? state_.count : place(due.back().number) + 1);
}

} // namespace insitu::scene
