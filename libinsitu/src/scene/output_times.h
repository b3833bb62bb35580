#pragma once

#include <cstdint>
#include <vector>

#include "scene/description.h"

namespace insitu::scene {

/// When a tracer's particles are written, if at times of their own.
class OutputClock {
public:
  /// What a checkpoint keeps.
  struct State {
    bool begun = false;     ///< the tracer was executed
    double first = 0.0;     ///< the time of its first execution
    std::int64_t count = 0; ///< of the times before the next one
  };
  /// One of the times.
  struct Due {
    double time;
    std::int64_t number; ///< of it: of a list, its place there
  };

  explicit OutputClock(const OutputTimes& times) : times_(times) {}

  /// The times after the last noted() one up to `time`, in order; of the first execution, that one
  /// alone. Throws core::Error (INSITU_ERROR_ARGUMENT) for more than most of them.
  std::vector<Due> due(double time) const;
  /// The particles were moved to `time`.
  void note(double time, const std::vector<Due>& due);

  const State& state() const { return state_; }
  void set_state(const State& state) { state_ = state; }

  static constexpr std::int64_t most = 1'000'000; ///< in one cycle

private:
  OutputTimes times_;
  State state_;
};

} // namespace insitu::scene
