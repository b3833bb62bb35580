#include "scene/release.h"

#include <cmath>
#include <string>

#include "core/status.h"

namespace insitu::scene {

std::vector<double> ReleaseClock::due(std::int64_t cycle, double time) const {
  const double until = release_.until.value_or(std::numeric_limits<double>::infinity());
  std::vector<double> times;
  if (release_.every) {
    if (cycle % *release_.every == 0 && time <= until)
      times.push_back(time);
  } else if (release_.interval) {
    const double first = state_.begun ? state_.first : time;
    const double last = std::min(time, until);
    // By multiplication, so that no error adds up; the first one is exactly `first`.
    const double rounds = std::floor((last - first) / *release_.interval);
    if (rounds - double(state_.rounds) >= double(most_rounds))
      throw core::Error(INSITU_ERROR_ARGUMENT,
                        "release: the interval " + std::to_string(*release_.interval) +
                            " asks for more than " + std::to_string(most_rounds) +
                            " releases in one cycle, up to time " + std::to_string(time));
    for (std::int64_t k = state_.rounds;; ++k) {
      const double at = first + double(k) * *release_.interval;
      if (!(at <= last))
        break;
      times.push_back(at);
    }
  } else if (state_.rounds == 0 && time <= until) {
    times.push_back(time);
  }
  return times;
}

void ReleaseClock::note(double time, std::size_t rounds) {
  if (!state_.begun)
    state_.first = time;
  state_.begun = true;
  state_.rounds += std::int64_t(rounds);
}

bool ReleaseClock::goes_on(double time) const {
  if (release_.once() && state_.rounds > 0)
    return false;
  if (!release_.until)
    return true;
  if (release_.interval && state_.begun)
    return state_.first + double(state_.rounds) * *release_.interval <= *release_.until;
  return time <= *release_.until;
}

} // namespace insitu::scene
