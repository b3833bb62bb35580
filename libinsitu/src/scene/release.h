#pragma once

#include <cstdint>
#include <vector>

#include "scene/description.h"

namespace insitu::scene {

/// When a tracer's seeds begin as particles.
class ReleaseClock {
public:
  /// What a checkpoint keeps.
  struct State {
    bool begun = false;      ///< the tracer was executed
    double first = 0.0;      ///< the time of its first execution
    std::int64_t rounds = 0; ///< so many times all seeds began
  };

  explicit ReleaseClock(const Release& release) : release_(release) {}

  /// The times at which all seeds begin, after the last call's and up to `time`, in order. Throws
  /// core::Error (INSITU_ERROR_ARGUMENT) for more than most_rounds of them.
  std::vector<double> due(std::int64_t cycle, double time) const;
  /// The times of due() were released.
  void note(double time, std::size_t rounds);
  /// They were not, since the condition of the release does not hold; a single release waits.
  void pass(double time, std::size_t rounds) { note(time, release_.once() ? 0 : rounds); }
  /// Whether particles may begin after this time.
  bool goes_on(double time) const;

  const State& state() const { return state_; }
  void set_state(const State& state) { state_ = state; }

  static constexpr std::int64_t most_rounds = 1'000'000; ///< in one cycle

private:
  Release release_;
  State state_;
};

} // namespace insitu::scene
