#pragma once

#include <cstdint>
#include <vector>

#include "scene/parse/description.h"
#include "scene/run/even_times.h"

namespace insitu::scene {

/// When a tracer's seeds begin as particles.
class ReleaseClock {
public:
  /// Times are the run's, which go on as `own` says.
  explicit ReleaseClock(const Release& release, OwnTime own = OwnTime(false))
      : release_(release), own_(own) {
    if (release_.until)
      release_.until = own.of(*release_.until);
  }

  /// The times at which all seeds begin, after the last call's and up to `time`, in order. Throws
  /// core::Error (INSITU_ERROR_ARGUMENT) for more than most_times of them.
  std::vector<double> due(std::int64_t cycle, double time) const;
  /// The times of due() were released.
  void note(double time, std::size_t rounds);
  /// They were not, since the condition of the release does not hold; a single release waits.
  void pass(double time, std::size_t rounds) { note(time, release_.once() ? 0 : rounds); }
  /// Whether particles may begin after this time.
  bool goes_on(double time) const;

  void keep(core::Archive& archive) { state_.keep(archive, "releases"); }

private:
  Release release_; ///< in its own time
  OwnTime own_;
  SeriesState state_; ///< count: so many times all seeds began
};

} // namespace insitu::scene
