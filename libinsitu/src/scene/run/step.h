#pragma once

#include <cstdint>
#include <span>

#include "commit/committed_mesh.h"

namespace insitu::scene {

using MeshList = std::span<commit::CommittedMesh* const>;

/// One cycle, as actions see it.
struct Step {
  MeshList meshes;
  std::int64_t cycle;
  double time;
  bool first;                                ///< the first execution of the session
  double earlier_time;                       ///< of the execution before
  std::span<const double> times_before = {}; ///< of those before it, as far as fields may look back
};

} // namespace insitu::scene
