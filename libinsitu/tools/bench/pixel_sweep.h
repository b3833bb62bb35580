#pragma once

#include <string>

#include "core/memory.h"
#include "query/committed_mesh.h"
#include "render/frame.h"

namespace insitu::bench {

/// How a frame's time goes with its pixels: the same frame at half to twice the size.
struct PixelSweep {
  std::string text, json;
};

/// On one core, with structures that are kept.
PixelSweep sweep_pixels(const query::CommittedMesh& mesh, core::Memory& memory,
                        render::FrameSettings settings, int size, int repetitions);

} // namespace insitu::bench
