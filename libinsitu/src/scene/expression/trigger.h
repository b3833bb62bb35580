#pragma once

#include <cstdint>
#include <optional>

#include "scene/expression/expression.h"

namespace insitu::scene {

/// When something of the scene happens: at every `every`-th cycle (cycle 0 included) at which
/// `when` holds.
struct Trigger {
  std::int64_t every = 1;         ///< cycles, >= 1
  std::optional<Expression> when; ///< nothing: always
  int line = 0;                   ///< of `when`, or of `every`; 0 where neither was given

  /// `reduce` is called only where `when` is given and the cycle is a multiple of `every`.
  bool due(std::int64_t cycle, double time, const Expression::Reduce& reduce) const {
    return cycle % every == 0 && (!when || when->evaluate(cycle, time, reduce));
  }
};

} // namespace insitu::scene
