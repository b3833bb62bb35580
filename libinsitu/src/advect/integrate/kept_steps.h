#pragma once

#include <cstdint>

#include "math/vec.h"

namespace insitu::advect {

/// An Integration between two of its steps (see there for what the members are): plain data, which
/// another process may go on from.
struct KeptSteps {
  double from, direction, span;
  math::Vec3d k1;
  double elapsed, previous_error, rate_limit;
  std::int64_t steps;
  std::int32_t closing_in;
  bool closely;
  std::int32_t free_steps, idle_faces;
  bool confined, entered, told_to_end;
};

} // namespace insitu::advect
