#include "scene/output_times.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/status.h"

namespace insitu::scene {

std::vector<OutputClock::Due> OutputClock::due(double time) const {
  std::vector<Due> found;
  const auto refuse = [&](double many) {
    throw core::Error(INSITU_ERROR_ARGUMENT, "times: " + std::to_string(std::int64_t(many)) +
                                                 " of them in one cycle, up to time " +
                                                 std::to_string(time) + "; at most " +
                                                 std::to_string(most) + " can be had");
  };
  const double begin = state_.begun ? state_.first : time;
  if (!times_.at.empty()) {
    for (auto k = std::size_t(state_.count); k < times_.at.size() && times_.at[k] <= time; ++k)
      if (times_.at[k] >= begin)
        found.push_back({times_.at[k], std::int64_t(k)});
    if (found.size() > std::size_t(most))
      refuse(double(found.size()));
  } else if (times_.interval) {
    const double from = times_.from.value_or(begin), interval = *times_.interval;
    const double last =
        std::min(time, times_.until.value_or(std::numeric_limits<double>::infinity()));
    // Those before the first execution are passed over.
    const double skipped =
        state_.begun ? 0.0 : std::max(0.0, std::floor((begin - from) / interval) - 1.0);
    const double next = std::max(double(state_.count), skipped);
    const double many = std::floor((last - from) / interval) - next + 1.0;
    if (many > double(most))
      refuse(std::min(many, 9e18));
    // By multiplication, so that no error adds up; the first one is exactly `from`.
    for (double k = next;; ++k) {
      const double at = from + k * interval;
      if (!(at <= last))
        break;
      if (at >= begin)
        found.push_back({at, std::int64_t(k)});
    }
  }
  return found;
}

void OutputClock::note(double time, const std::vector<Due>& due) {
  if (!state_.begun)
    state_.first = time;
  state_.begun = true;
  if (!due.empty())
    state_.count = due.back().number + 1;
}

} // namespace insitu::scene
