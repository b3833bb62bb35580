#pragma once

#include <cstdint>
#include <string>

#include "core/context.h"
#include "scene/frames/cinema_table.h"
#include "scene/frames/frame_structures.h"
#include "scene/run/page_record.h"
#include "scene/run/statistics.h"

namespace insitu::scene {

/// What every action is made with.
struct Environment {
  core::Context& context;
  Statistics& statistics;
  FrameStructures& structures;
  CinemaTable& table;         ///< of the frames' files
  std::string scene_file;     ///< for messages
  std::string output;         ///< folder
  PageRecord* page = nullptr; ///< null: the scene has none
};

/// `<output>/<name>_<cycle, six digits><extension>`
std::string cycle_path(const Environment& environment, const std::string& name, std::int64_t cycle,
                       const std::string& extension);

} // namespace insitu::scene
