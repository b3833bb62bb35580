#include "scene/tracers/release.h"

#include <algorithm>
#include <limits>

namespace insitu::scene {

std::vector<double> ReleaseClock::due(std::int64_t cycle, double run_time) const {
  const double time = own_.of(run_time);
  const double until = release_.until.value_or(std::numeric_limits<double>::infinity());
  std::vector<double> times;
  if (release_.every) {
    if (cycle % *release_.every == 0 && time <= until)
      times.push_back(time);
  } else if (release_.interval) {
    const double first = state_.begun ? state_.first : time;
    for (const DueTime& due :
         even_times("release", first, *release_.interval, state_.count, std::min(time, until)))
      times.push_back(due.time);
  } else if (state_.count == 0 && time <= until) {
    times.push_back(time);
  }
  for (double& at : times)
    at = own_.of(at);
  return times;
}

void ReleaseClock::note(double time, std::size_t rounds) {
  state_.note(own_.of(time), state_.count + std::int64_t(rounds));
}

bool ReleaseClock::goes_on(double time) const {
  if (release_.once() && state_.count > 0)
    return false;
  if (!release_.until)
    return true;
  if (release_.interval && state_.begun)
    return state_.first + double(state_.count) * *release_.interval <= *release_.until;
  return own_.of(time) <= *release_.until;
}

} // namespace insitu::scene
