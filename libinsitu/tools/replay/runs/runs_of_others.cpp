#include "runs/runs_of_others.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#ifdef REPLAY_CGNS
#include <vtkCGNSReader.h>
#ifdef REPLAY_CGNS_LIBRARY
#include <vtk_cgns.h>
#include VTK_CGNS(cgns_io.h)
#endif
#endif
#ifdef REPLAY_EXODUS
#include <vtkExodusIIReader.h>
#endif

#include "read.h"
#include "runs/netcdf/cf.h"
#include "runs/netcdf/classic_size.h"
#include "runs/netcdf/ugrid.h"
#include "runs/openfoam.h"
#include "runs/vtk_run.h"

namespace insitu_replay {

namespace fs = std::filesystem;

const char* const run_kinds = "a folder of OpenFOAM, .foam, .exo, .e, .ex2, .g, .cgns or .nc";

namespace {

enum class Kind { none, openfoam, exodus, cgns, netcdf };

Kind kind_of(const std::string& path) {
  if (is_openfoam_case(path))
    return Kind::openfoam;
  const std::string ending = ending_of(path);
  const auto is = [&](std::initializer_list<const char*> endings) {
    return std::find(endings.begin(), endings.end(), ending) != endings.end();
  };
  return is({".foam", ".openfoam"})                  ? Kind::openfoam
         : is({".exo", ".e", ".ex2", ".exii", ".g"}) ? Kind::exodus
         : is({".cgns"})                             ? Kind::cgns
         : is({".nc"})                               ? Kind::netcdf
                                                     : Kind::none;
}

#ifdef REPLAY_EXODUS
std::unique_ptr<Run> open_exodus(const std::string& path) {
  require_whole_netcdf(path); // which most of these files are
  const auto reader = vtkSmartPointer<vtkExodusIIReader>::New();
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  reader->SetAllArrayStatus(vtkExodusIIReader::NODAL, 1);
  reader->SetAllArrayStatus(vtkExodusIIReader::ELEM_BLOCK, 1);
  reader->SetGenerateObjectIdCellArray(0);
  return std::make_unique<VtkRun>(path, reader);
}
#endif

#ifdef REPLAY_CGNS
/// VTK's reader ends the program where the CGNS library cannot open the file.
void require_cgns(const std::string& path) {
#ifdef REPLAY_CGNS_LIBRARY
  int file = 0;
  if (cgio_open_file(path.c_str(), CGIO_MODE_READ, CGIO_FILE_NONE, &file) != CGIO_ERR_NONE) {
    char message[CGIO_MAX_ERROR_LENGTH + 1] = {};
    cgio_error_message(message);
    throw FileError(path, std::string("is no CGNS file, or is cut short: ") + message);
  }
  cgio_close_file(file);
#else
  (void)path;
#endif
}

std::unique_ptr<Run> open_cgns(const std::string& path) {
  require_cgns(path);
  const auto reader = vtkSmartPointer<vtkCGNSReader>::New();
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  reader->EnableAllBases();
  reader->EnableAllFamilies();
  reader->EnableAllPointArrays();
  reader->EnableAllCellArrays();
  return std::make_unique<VtkRun>(path, reader);
}
#endif

/// Makes a reader, or says that this VTK has none.
std::unique_ptr<Run> open_run(const std::string& path) {
  switch (kind_of(path)) {
#ifdef REPLAY_OPENFOAM
  case Kind::openfoam: {
    const fs::path above = fs::path(path).parent_path();
    return open_openfoam(is_openfoam_case(path) ? path : above.empty() ? "." : above.string());
  }
#endif
#ifdef REPLAY_EXODUS
  case Kind::exodus:
    return open_exodus(path);
#endif
#ifdef REPLAY_CGNS
  case Kind::cgns:
    return open_cgns(path);
#endif
  case Kind::netcdf:
    if (std::unique_ptr<Run> run = open_ugrid(path))
      return run;
#ifdef REPLAY_NETCDF
    return open_cf(path);
#endif
    [[fallthrough]];
  default:
    throw FileError(path, "the VTK of this build has no reader of such files");
  }
}

/// Runs are kept, since readers read what does not change once.
Run& run_of(const std::string& path) {
  static std::map<std::string, std::unique_ptr<Run>> runs;
  std::unique_ptr<Run>& run = runs[path];
  if (!run) {
    forget_messages();
    if (!is_openfoam_case(path))
      require_readable(path);
    run = open_run(path);
    if (const std::string message = first_message(); !message.empty())
      throw FileError(path, "cannot be read: " + message);
  }
  return *run;
}

} // namespace

bool is_openfoam_case(const std::string& folder) {
  std::error_code error;
  return fs::is_directory(folder, error) &&
         fs::exists(fs::path(folder) / "system" / "controlDict", error);
}

bool holds_a_run(const std::string& path) {
  return kind_of(path) != Kind::none;
}

std::vector<double> times_of_run(const std::string& path) {
  return run_of(path).times();
}

vtkSmartPointer<vtkDataObject> read_run(const std::string& path, std::optional<double> time) {
  return run_of(path).read(time);
}

std::optional<insitu::Frame> frame_of_run(const std::string& path) {
  return run_of(path).frame();
}

std::vector<std::string> notes_of_run(const std::string& path) {
  return run_of(path).notes();
}

} // namespace insitu_replay
