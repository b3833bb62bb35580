#include "read.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vtkDataArray.h>
#include <vtkDataObjectTree.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkHyperTreeGrid.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkOverlappingAMR.h>
#include <vtkXMLGenericDataObjectReader.h>
#include <vtkXMLUniformGridAMRReader.h>

#ifdef REPLAY_HDF
#include <vtkHDFReader.h>
#endif

#include "hyper_trees.h"

namespace insitu_replay {

namespace fs = std::filesystem;

const char* const readable_kinds = ".vtu, .vts, .vtr, .vti, .pvtu, .pvts, .pvtr, .pvti, .vtm, "
                                   ".vtk, .vthb, .vth, .htg, .hdf, .pvd or .series";

namespace {

constexpr const char* endings[] = {".vtu",  ".vts", ".vtr", ".vti",  ".pvtu", ".pvts", ".pvtr",
                                   ".pvti", ".vtm", ".vtk", ".vthb", ".vth",  ".htg",  ".hdf"};

/// Takes VTK's messages instead of the terminal.
class QuietWindow : public vtkOutputWindow {
public:
  static QuietWindow* New();
  vtkTypeMacro(QuietWindow, vtkOutputWindow)

      void DisplayText(const char* text) override {
    // What VTK's own writer makes of a grid without points is no fault.
    if (first.empty() && text && !std::strstr(text, "No Points element available in first piece"))
      first = text;
  }
  std::string first;

protected:
  QuietWindow() = default;
};

vtkStandardNewMacro(QuietWindow)

    QuietWindow* window = nullptr;

void read_all_of(vtkXMLReader*) {}
#ifdef REPLAY_HDF
void read_all_of(vtkHDFReader*) {}
#endif
void read_all_of(vtkXMLGenericDataObjectReader*) {}
/// The first array of each kind alone otherwise.
void read_all_of(vtkDataReader* reader) {
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllTensorsOn();
  reader->ReadAllTCoordsOn();
  reader->ReadAllColorScalarsOn();
  reader->ReadAllFieldsOn();
}
/// It reads the coarsest level alone otherwise, whatever its documentation says.
void read_all_of(vtkXMLUniformGridAMRReader* reader) {
  reader->SetMaximumLevelsToReadByDefault(0);
}

/// What a reader makes of a file; null if it fails.
template <class Reader>
vtkSmartPointer<vtkDataObject> read_by(const std::string& path) {
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  read_all_of(reader);
  reader->Update();
  return reader->GetErrorCode() == 0 ? reader->GetOutputDataObject(0) : nullptr;
}

/// The first value of the first of these arrays.
std::optional<double> field_data(vtkDataObject* data, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    vtkDataArray* array = data->GetFieldData()->GetArray(name);
    if (array && array->GetNumberOfValues() > 0 && std::isfinite(array->GetComponent(0, 0)))
      return array->GetComponent(0, 0);
  }
  return std::nullopt;
}

} // namespace

std::string first_message() {
  if (!window)
    return {};
  std::string text = window->first;
  if (const auto colon = text.find("): "); colon != std::string::npos)
    text = text.substr(colon + 3);
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && text.back() == ' ')
    text.pop_back();
  return text;
}

void forget_messages() {
  if (window)
    window->first.clear();
}

void require_readable(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error))
    throw FileError(path, "no such file");
  if (fs::is_directory(path, error))
    throw FileError(path, "is a folder");
  if (!std::ifstream(path))
    throw FileError(path, "cannot be opened");
}

std::string ending_of(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  for (char& c : ending)
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

bool is_readable_kind(const std::string& path) {
  return std::find(std::begin(endings), std::end(endings), ending_of(path)) != std::end(endings);
}

namespace {

#ifdef REPLAY_HDF
using HdfFileReader = vtkHDFReader;
#else
/// Reads nothing, and fails.
using HdfFileReader = vtkXMLGenericDataObjectReader;
#endif

} // namespace

vtkSmartPointer<vtkDataObject> read(const std::string& path) {
  require_readable(path);
  forget_messages();
  const std::string ending = ending_of(path);
  const vtkSmartPointer<vtkDataObject> data =
      ending == ".htg"                        ? read_by<HyperTreeReader>(path)
      : ending == ".hdf"                      ? read_by<HdfFileReader>(path)
      : ending == ".vthb" || ending == ".vth" ? read_by<vtkXMLUniformGridAMRReader>(path)
      : ending == ".vtk"                      ? read_by<vtkGenericDataObjectReader>(path)
                                              : read_by<vtkXMLGenericDataObjectReader>(path);
  const std::string message = first_message();
  if (!message.empty() ||
      !(vtkDataSet::SafeDownCast(data) || vtkDataObjectTree::SafeDownCast(data) ||
        vtkOverlappingAMR::SafeDownCast(data) || vtkHyperTreeGrid::SafeDownCast(data)))
    throw FileError(path, std::string("cannot be read as a ") +
                              (ending == ".vtk"   ? "legacy VTK file"
                               : ending == ".hdf" ? "record or VTKHDF file"
                                                  : "VTK XML data set") +
                              (message.empty() ? std::string() : ": " + message));
  return data;
}

std::optional<std::int64_t> cycle_of(vtkDataObject* data) {
  const std::optional<double> cycle = field_data(data, {"CYCLE", "cycle", "Cycle"});
  if (!cycle)
    return std::nullopt;
  return static_cast<std::int64_t>(std::llround(*cycle));
}

std::optional<double> time_of(vtkDataObject* data) {
  return field_data(data, {"TimeValue", "TIME", "time", "Time"});
}

void silence_vtk() {
  static const vtkNew<QuietWindow> quiet;
  window = quiet;
  vtkOutputWindow::SetInstance(quiet);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

} // namespace insitu_replay
