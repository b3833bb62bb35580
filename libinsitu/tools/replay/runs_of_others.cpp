#include "runs_of_others.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <vtkAlgorithm.h>
#include <vtkDataObjectTree.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#ifdef REPLAY_CGNS
#include <vtkCGNSReader.h>
#endif
#ifdef REPLAY_EXODUS
#include <vtkExodusIIReader.h>
#endif
#ifdef REPLAY_OPENFOAM
#include <vtkOpenFOAMReader.h>
#endif
#ifdef REPLAY_NETCDF
#include <vtkNetCDFCFReader.h>
#endif

#include "read.h"

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

#ifdef REPLAY_OPENFOAM
/// The inner mesh with the fields of its cells, as the solver has them; polyhedra as they are.
vtkSmartPointer<vtkAlgorithm> open_openfoam(const std::string& path) {
  const auto reader = vtkSmartPointer<vtkOpenFOAMReader>::New();
  const fs::path folder = fs::is_directory(path) ? fs::path(path) : fs::path(path).parent_path();
  reader->SetFileName((folder / "system" / "controlDict").string().c_str());
  reader->SetCreateCellToPoint(0);
  reader->SetDecomposePolyhedra(0);
  reader->SetSkipZeroTime(false);
  reader->UpdateInformation();
  reader->EnableAllCellArrays();
  reader->DisableAllPatchArrays();
  reader->SetPatchArrayStatus("internalMesh", 1);
  return reader;
}
#endif

#ifdef REPLAY_EXODUS
vtkSmartPointer<vtkAlgorithm> open_exodus(const std::string& path) {
  const auto reader = vtkSmartPointer<vtkExodusIIReader>::New();
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  reader->SetAllArrayStatus(vtkExodusIIReader::NODAL, 1);
  reader->SetAllArrayStatus(vtkExodusIIReader::ELEM_BLOCK, 1);
  reader->SetGenerateObjectIdCellArray(0);
  return reader;
}
#endif

#ifdef REPLAY_CGNS
vtkSmartPointer<vtkAlgorithm> open_cgns(const std::string& path) {
  const auto reader = vtkSmartPointer<vtkCGNSReader>::New();
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  reader->EnableAllBases();
  reader->EnableAllFamilies();
  reader->EnableAllPointArrays();
  reader->EnableAllCellArrays();
  return reader;
}
#endif

#ifdef REPLAY_NETCDF
/// Longitudes, latitudes and levels as they are, for --frame.
vtkSmartPointer<vtkAlgorithm> open_netcdf(const std::string& path) {
  const auto reader = vtkSmartPointer<vtkNetCDFCFReader>::New();
  reader->SetFileName(path.c_str());
  reader->SphericalCoordinatesOff();
  reader->ReplaceFillValueWithNanOn();
  reader->UpdateInformation();
  return reader;
}
#endif

/// Makes a reader, or says that this VTK has none.
vtkSmartPointer<vtkAlgorithm> open_run(const std::string& path) {
  switch (kind_of(path)) {
#ifdef REPLAY_OPENFOAM
  case Kind::openfoam:
    return open_openfoam(path);
#endif
#ifdef REPLAY_EXODUS
  case Kind::exodus:
    return open_exodus(path);
#endif
#ifdef REPLAY_CGNS
  case Kind::cgns:
    return open_cgns(path);
#endif
#ifdef REPLAY_NETCDF
  case Kind::netcdf:
    return open_netcdf(path);
#endif
  default:
    throw FileError(path, "the VTK of this build has no reader of such files");
  }
}

/// Readers are kept, since they read what does not change once.
vtkAlgorithm& reader_of(const std::string& path) {
  static std::map<std::string, vtkSmartPointer<vtkAlgorithm>> readers;
  vtkSmartPointer<vtkAlgorithm>& reader = readers[path];
  if (!reader) {
    forget_messages();
    if (!is_openfoam_case(path))
      require_readable(path);
    reader = open_run(path);
    if (const std::string message = first_message(); !message.empty())
      throw FileError(path, "cannot be read: " + message);
  }
  return *reader;
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
  vtkInformation* const about = reader_of(path).GetOutputInformation(0);
  std::vector<double> times;
  if (about->Has(vtkStreamingDemandDrivenPipeline::TIME_STEPS())) {
    const double* const first = about->Get(vtkStreamingDemandDrivenPipeline::TIME_STEPS());
    times.assign(first, first + about->Length(vtkStreamingDemandDrivenPipeline::TIME_STEPS()));
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

vtkSmartPointer<vtkDataObject> read_run(const std::string& path, std::optional<double> time) {
  vtkAlgorithm& reader = reader_of(path);
  forget_messages();
  if (time)
    reader.UpdateTimeStep(*time);
  else
    reader.Update();
  vtkDataObject* const read = reader.GetOutputDataObject(0);
  if (const std::string message = first_message(); !message.empty() || !read)
    throw FileError(path, "cannot be read" + (message.empty() ? message : ": " + message));
  // The reader's own object becomes the next step's.
  auto kept = vtkSmartPointer<vtkDataObject>::Take(read->NewInstance());
  if (auto* const tree = vtkDataObjectTree::SafeDownCast(kept))
    tree->RecursiveShallowCopy(read);
  else
    kept->ShallowCopy(read);
  return kept;
}

} // namespace insitu_replay
