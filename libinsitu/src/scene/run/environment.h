#pragma once

#include <cstdint>
#include <string>

#include "core/context.h"
#include "parallel/world.h"
#include "scene/expression/reduce.h"
#include "scene/frames/cinema_table.h"
#include "scene/frames/frame_structures.h"
#include "scene/run/page_record.h"
#include "scene/run/statistics.h"

namespace insitu::scene {

/// Every action is made with an Environment.
struct Environment {
  core::Context& context;
  parallel::World& world; ///< the processes of the session; see Action::execute()
  Statistics& statistics;
  FrameStructures& structures;
  FieldReductions& reductions;
  CinemaTable& table;         ///< the table of the files of frames
  std::string scene_file;     ///< path of the scene file, for messages
  std::string output;         ///< output folder
  PageRecord* page = nullptr; ///< the page of the run; null: the scene asks for no page, or the
                              ///< root has it
};

/// Returns the path `<output>/<name>_<cycle, six digits><extension>`.
std::string cycle_path(const Environment& environment, const std::string& name, std::int64_t cycle,
                       const std::string& extension);

} // namespace insitu::scene
