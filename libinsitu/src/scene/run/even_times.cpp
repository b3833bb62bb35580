#include "scene/run/even_times.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"

namespace insitu::scene {

void SeriesState::note(double time, std::int64_t passed) {
  if (!begun)
    first = time;
  begun = true;
  count = passed;
}

void SeriesState::keep(core::Archive& archive, const std::string& what) {
  archive.value((what + " begun").c_str(), begun);
  archive.value((what + " first").c_str(), first);
  archive.value((what + " passed").c_str(), count);
}

void refuse_times(const char* what, double many, double last) {
  throw core::Error(INSITU_ERROR_ARGUMENT,
                    std::string(what) + ": " + std::to_string(std::int64_t(std::min(many, 9e18))) +
                        " times in one cycle, up to time " + std::to_string(last) + "; at most " +
                        std::to_string(most_times) + " can be had");
}

std::vector<DueTime> even_times(const char* what, double from, double interval, std::int64_t next,
                                double last) {
  const double many = std::floor((last - from) / interval) - double(next) + 1.0;
  if (many > double(most_times))
    refuse_times(what, many, last);
  std::vector<DueTime> times;
  // By multiplication, so that no error adds up; the first one is exactly `from`.
  for (std::int64_t k = next;; ++k) {
    const double at = from + double(k) * interval;
    if (!(at <= last))
      return times;
    times.push_back({at, k});
  }
}

} // namespace insitu::scene
