#pragma once

#include <optional>
#include <string>
#include <vector>

namespace insitu_replay {

/// One step: a file, or the parts of one.
struct Step {
  std::vector<std::string> files;
  std::optional<double> time; ///< from an index, or of a run in one file
  bool is_of_run = false;     ///< the file holds other steps too (runs_of_others.h)
};

/// The steps of the files given, indices (.pvd, .series) opened. Throws FileError.
std::vector<Step> steps_of(const std::vector<std::string>& files);

/// Whether numbers in the names (mesh_9, mesh_10) run against the order of the files.
bool numbers_run_backwards(const std::vector<std::string>& files);

} // namespace insitu_replay
