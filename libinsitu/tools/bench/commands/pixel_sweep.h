#pragma once

#include <string>

#include "commit/committed_mesh.h"
#include "core/memory.h"
#include "report/json.h"
#include "render/frame.h"

namespace insitu::bench {

/// How a frame's time goes with its pixels: the same frame at half to twice the size.
struct PixelSweep {
  std::string text;
  Json json; ///< an object
};

/// On one core, with structures that are kept.
PixelSweep sweep_pixels(const commit::CommittedMesh& mesh, core::Memory& memory,
                        render::FrameSettings settings, int size, int repetitions);

} // namespace insitu::bench
