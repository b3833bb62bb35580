#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/context.h"
#include "output/vtk/file_series.h"
#include "parallel/world.h"
#include "scene/run/statistics.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// What a record tells of its step besides the meshes.
struct RecordedStep {
  std::int64_t cycle = 0;
  double time = 0.0;
  std::string scene_file, scene_text; ///< empty: the session has no scene
};

/// The records of a run: files that hold what a solver gave for its meshes at a step, from which
/// insitu-replay does the step again, and a `.hdf.series` index beside files whose names end in a
/// number. design/records.md tells the format.
class Records {
public:
  /// All are kept by the caller.
  Records(core::Context& context, parallel::World& world, Statistics& statistics)
      : context_(context), world_(world), statistics_(statistics) {}

  /// Writes a file, which is the root's, whole or not at all. descends: the run's times do.
  /// Collective; throws parallel::AgreedError.
  void write(const std::string& path, const RecordedStep& step, MeshList meshes,
             bool descends = false);

private:
  void add_to_series(const std::string& path, double time, bool descends);

  core::Context& context_;
  parallel::World& world_;
  Statistics& statistics_;
  std::map<std::string, output::FileSeries> series_; ///< by path; at the root
};

/// The file of a scene's record at a cycle.
std::string record_path(const std::string& folder, std::int64_t cycle);

/// The index of the series that a file belongs to: "a/run.hdf.series" of "a/run_000120.hdf"; empty
/// if its name does not end in a number.
std::string series_path(const std::string& path);

} // namespace insitu::scene
