#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/archive.h"

namespace insitu::scene {

/// One of the times at which a tracer does something.
struct DueTime {
  double time;
  std::int64_t number; ///< of it in the series: from 0; of a list, its place there
};

/// How far a tracer has come in its series of times.
struct SeriesState {
  bool begun = false;     ///< the tracer was executed
  double first = 0.0;     ///< the time of its first execution
  std::int64_t count = 0; ///< of the times passed

  /// The tracer came to `time`, and to so many of the times.
  void note(double time, std::int64_t passed);
  /// To a checkpoint or back. what: of which series.
  void keep(core::Archive& archive, const std::string& what);
};

/// A tracer's own time, which always grows: minus the run's where that goes backward.
class OwnTime {
public:
  explicit OwnTime(bool backward) : backward_(backward) {}
  double of(double time) const { return backward_ ? 0.0 - time : time; } ///< and back
  bool is_before(double a, double b) const { return of(a) < of(b); }     ///< of the run's times
  bool backward() const { return backward_; }

private:
  bool backward_;
};

constexpr std::int64_t most_times = 1'000'000; ///< of a series, in one cycle

/// The times from + k interval, from k = next on, up to `last`. Throws core::Error
/// (INSITU_ERROR_ARGUMENT) for more than most_times of them; what: whose, for that message.
std::vector<DueTime> even_times(const char* what, double from, double interval, std::int64_t next,
                                double last);
/// Throws it.
[[noreturn]] void refuse_times(const char* what, double many, double last);

} // namespace insitu::scene
