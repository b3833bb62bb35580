#pragma once

#include <optional>
#include <string>
#include <vector>
#include <vtkSmartPointer.h>

#include "insitu/insitu.hpp"

class vtkDataObject;

namespace insitu_replay {

/// Files and folders in which other programs keep all steps of a run, with the readers that this
/// VTK has: OpenFOAM's cases (a folder, or a .foam file in it), Exodus, CGNS, netCDF by the CF
/// conventions; and netCDF by the UGRID conventions.
bool holds_a_run(const std::string& path);
/// Whether a folder is a case of OpenFOAM.
bool is_openfoam_case(const std::string& folder);
/// The kinds in words, for messages.
extern const char* const run_kinds;

/// Its times, ascending; none of a file that knows no time. Throws FileError.
std::vector<double> times_of_run(const std::string& path);
/// The data of one of these times, all arrays and blocks; empty: of a file that knows none. Throws
/// FileError.
vtkSmartPointer<vtkDataObject> read_run(const std::string& path, std::optional<double> time);
/// In which frame of reference the file says that its points are. Throws FileError.
std::optional<insitu::Frame> frame_of_run(const std::string& path);
/// What is left out, or is not as it stands in the file; each text names the file. Throws
/// FileError.
std::vector<std::string> notes_of_run(const std::string& path);

} // namespace insitu_replay
