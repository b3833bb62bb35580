#pragma once

#include <string>

#include "report/json.h"
#include "options.h"

namespace insitu::bench {

/// Frames of adaptive meshes with and without what the transfer function makes invisible, and what
/// it costs to tell.
struct AmrFrames {
  std::string text;
  Json json;
  bool differ = false; ///< some image is another one when cells are culled
};
AmrFrames measure_amr_frames(const Options& options);

} // namespace insitu::bench
