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
};

} // namespace insitu::scene
