#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "insitu/insitu.hpp"

namespace insitu_replay {

/// Meshes by their names.
using NamedMeshes = std::vector<std::pair<std::string, insitu::Mesh>>;

/// A dry run of a session of which the meshes were given: prints the meshes with their fields, the
/// number of steps, the files that the scene asks for, and memory. scene_text: of the scene, or ""
/// of the default one; folder: in the place of the scene's output folder, or "". Returns the items
/// that cannot be done, "probe 'gauges' ...: reason" each.
std::vector<std::string> check_run(insitu::Session& session, const NamedMeshes& meshes,
                                   std::size_t steps, const std::string& scene_text,
                                   const std::string& folder);

/// Prints what is found in meshes of a file, a line each and more for those that are refused;
/// returns whether none is.
bool validate_meshes(const NamedMeshes& meshes, const std::string& file);

/// The text of a file; "" where there is none.
std::string text_of(const std::string& path);

/// "1 step", "2 steps".
std::string plural(std::int64_t n, const std::string& what);

} // namespace insitu_replay
