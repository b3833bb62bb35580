#pragma once

#include <span>
#include <string>

#include "render/frame.h"

namespace insitu::bench {

/// A bare frame: what it did, and in how many seconds of one core.
struct BareFrame {
  std::string family; ///< "volume", "isosurface" or "path tracing"
  render::FrameStatistics statistics;
  double seconds = 0;
};

/// What bare frames pay for effects that they do not ask for. Where an effect sits in the inner
/// loop there is a loop without it (VolumeMarcher::gather_plainly); the rest are branches that go
/// the same way in a whole frame. How many of them a frame meets is bounded by its counts of work,
/// and what one costs is measured: a flag in memory, tested, the branch predicted.
class UniformBranches {
public:
  explicit UniformBranches(int repetitions);

  double nanoseconds() const { return 1e9 * seconds_each_; }
  /// At most the part of a frame's time that is spent on them.
  double share(const BareFrame& frame) const;
  std::string text(std::span<const BareFrame> frames) const;
  std::string json(std::span<const BareFrame> frames) const;

private:
  double seconds_each_ = 0;
};

} // namespace insitu::bench
