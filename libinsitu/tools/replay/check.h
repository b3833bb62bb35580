#pragma once

#include <string>
#include <vector>

#include "insitu/insitu.hpp"

namespace insitu_replay {

/// What --check says of a mesh: its cells and vertices, and each field.
std::string describe(const std::string& name, insitu::Mesh mesh);

/// The files that a scene asks for, a line each, with when they are written; empty for a text that
/// is none. folder: in the place of the scene's.
std::string outputs_of(const std::string& scene_text, const std::string& folder);

/// The lines of a plan that say why an item cannot be done: "probe 'gauges' ...: reason".
std::vector<std::string> problems_of(const std::string& plan);
/// Its last line, which sums memory up.
std::string memory_of(const std::string& plan);

} // namespace insitu_replay
