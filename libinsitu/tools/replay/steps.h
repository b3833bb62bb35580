#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>
#include <vtkSmartPointer.h>

class vtkDataObject;

namespace insitu_replay {

/// A file that cannot be read; what() begins with its name.
struct FileError : std::runtime_error {
  FileError(const std::string& path, const std::string& what)
      : std::runtime_error(path + ": " + what) {}
};

/// One step: a file, or the parts of one.
struct Step {
  std::vector<std::string> files;
  std::optional<double> time; ///< from a .pvd
};

/// The steps of the files given, .pvd indices opened. Throws FileError.
std::vector<Step> steps_of(const std::vector<std::string>& files);

/// Reads .vtu, .vts, .vtr or .vti, a vtkDataSet; .vthb or .vth, a vtkOverlappingAMR with all of its
/// grids; .htg, a vtkHyperTreeGrid. Throws FileError.
vtkSmartPointer<vtkDataObject> read(const std::string& path);

/// What the field data says.
std::optional<std::int64_t> cycle_of(vtkDataObject* data);
std::optional<double> time_of(vtkDataObject* data);

/// Whether numbers in the names (mesh_9, mesh_10) run against the order of the files.
bool numbers_run_backwards(const std::vector<std::string>& files);

/// From here on VTK prints nothing; read() puts its first error into the FileError.
void silence_vtk();

} // namespace insitu_replay
