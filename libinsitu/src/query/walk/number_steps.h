#pragma once

#include <cstdint>
#include <mutex>
#include <optional>

namespace insitu::query {

/// The steps from a cell's number to those of its neighbours, where most cells of a few have the
/// same: advect::CellsBeyond learns them.
struct NumberSteps {
  static constexpr int most_sides = 6;
  struct Of {
    std::int64_t step[most_sides] = {};
    unsigned known = 0; ///< bits of sides
  };
  Of bricks, wedges; ///< of hexahedra and voxels; of wedges
};

/// The steps of a committed mesh, which are learnt once a topology: vertices that move leave the
/// numbers of the cells as they are. Thread-safe but for forget().
class NumberStepsCache {
public:
  std::optional<NumberSteps> get() const {
    const std::lock_guard lock(mutex_);
    return steps_;
  }
  void put(const NumberSteps& steps) const {
    const std::lock_guard lock(mutex_);
    steps_ = steps;
  }
  void forget() { steps_.reset(); }

private:
  mutable std::mutex mutex_;
  mutable std::optional<NumberSteps> steps_;
};

} // namespace insitu::query
