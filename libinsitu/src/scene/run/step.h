#pragma once

#include <cstdint>
#include <span>

#include "commit/committed_mesh.h"

namespace insitu::scene {

using MeshList = std::span<commit::CommittedMesh* const>;

/// One cycle of the solver, as actions see it.
struct Step {
  MeshList meshes;
  std::int64_t cycle;
  double time;
  bool first;                                ///< whether this is the first execution of the session
  double earlier_time;                       ///< time of the execution before this one
  std::span<const double> times_before = {}; ///< times of the executions before earlier_time, as
                                             ///< far as fields may look back
  bool again = false; ///< whether the action was executed at this very step before, and failed
};

/// The step at which something was begun last, so that it is gone on with where a step comes again.
class StepNote {
public:
  /// Notes the step; returns whether it comes again and was the one noted before.
  bool again(const Step& step) {
    const bool known = step.again && is_set_ && step.cycle == cycle_ && step.time == time_;
    is_set_ = true;
    cycle_ = step.cycle;
    time_ = step.time;
    return known;
  }

private:
  bool is_set_ = false;
  std::int64_t cycle_ = 0;
  double time_ = 0.0;
};

} // namespace insitu::scene
