#pragma once

#include <span>
#include <string>

#include "report/json.h"
#include "render/frame.h"

namespace insitu::bench {

/// A bare frame: what it did, and in how many seconds of one core.
struct BareFrame {
  std::string family; ///< "volume", "isosurface" or "path tracing"
  render::FrameStatistics statistics;
  double seconds = 0;
  double branch_seconds = 0; ///< as measure_branch() found in turns with it
};

/// What bare frames pay for effects that they do not ask for. Where an effect sits in the inner
/// loop there is a loop without it (VolumeMarcher::gather_plainly); the rest are branches that go
/// the same way in a whole frame. How many of them a frame meets is bounded by its counts of work,
/// and what one costs is measured: a flag in memory, tested, the branch predicted.
namespace uniform_branches {

/// Seconds of one.
double measure_branch();
std::string text(std::span<const BareFrame> frames);
/// A row each to a list.
void add(std::span<const BareFrame> frames, Json& rows);

} // namespace uniform_branches

} // namespace insitu::bench
