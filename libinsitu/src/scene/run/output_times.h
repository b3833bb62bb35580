#pragma once

#include <cstdint>
#include <vector>

#include "scene/parse/description.h"
#include "scene/run/even_times.h"

namespace insitu::scene {

/// When a tracer's particles are written, if at times of their own.
class OutputClock {
public:
  /// Times are the run's, which go on as `own` says.
  explicit OutputClock(const OutputTimes& times, OwnTime own = OwnTime(false));

  /// The times after the last noted() one up to `time`, in order; of the first execution, that one
  /// alone. Throws core::Error (INSITU_ERROR_ARGUMENT) for more than most_times of them.
  std::vector<DueTime> due(double time) const;
  /// The particles were moved to `time`.
  void note(double time, const std::vector<DueTime>& due);

  void keep(core::Archive& archive) { state_.keep(archive, "times"); }

private:
  std::int64_t place(std::int64_t number) const;

  OutputTimes times_; ///< in its own time
  OwnTime own_;
  SeriesState state_;
};

} // namespace insitu::scene
