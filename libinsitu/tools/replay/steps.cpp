#include "steps.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkHyperTreeGrid.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkOverlappingAMR.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLGenericDataObjectReader.h>
#include <vtkXMLHyperTreeGridReader.h>
#include <vtkXMLUniformGridAMRReader.h>
#include <vtkXMLUtilities.h>

namespace insitu_replay {

namespace fs = std::filesystem;

namespace {

/// Takes VTK's messages instead of the terminal.
class QuietWindow : public vtkOutputWindow {
public:
  static QuietWindow* New();
  vtkTypeMacro(QuietWindow, vtkOutputWindow)

      void DisplayText(const char* text) override {
    if (first.empty() && text)
      first = text;
  }
  std::string first;

protected:
  QuietWindow() = default;
};

vtkStandardNewMacro(QuietWindow)

    QuietWindow* window = nullptr;

/// VTK's "ERROR: In file, line n\nvtkClass (0x...): message\n\n" without all but the message.
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

void require_readable(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error))
    throw FileError(path, "no such file");
  if (fs::is_directory(path, error))
    throw FileError(path, "is a folder");
  if (!std::ifstream(path))
    throw FileError(path, "cannot be opened");
}

std::vector<Step> read_pvd(const std::string& path) {
  require_readable(path);
  if (window)
    window->first.clear();
  const auto root =
      vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromFile(path.c_str()));
  vtkXMLDataElement* collection = root ? root->FindNestedElementWithName("Collection") : nullptr;
  if (!collection)
    throw FileError(path, "is no .pvd index: no Collection element");
  std::map<double, std::map<int, std::string>> by_time;
  for (int i = 0; i < collection->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* e = collection->GetNestedElement(i);
    if (std::string(e->GetName()) != "DataSet")
      continue;
    const char* file = e->GetAttribute("file");
    if (!file)
      throw FileError(path, "DataSet " + std::to_string(i) + " names no file");
    double time = 0;
    int part = 0;
    if (e->GetAttribute("timestep") && e->GetScalarAttribute("timestep", time) != 1)
      throw FileError(path, "DataSet " + std::to_string(i) + ": timestep '" +
                                e->GetAttribute("timestep") + "' is no number");
    if (!std::isfinite(time))
      throw FileError(path, "DataSet " + std::to_string(i) + ": timestep is not finite");
    if (e->GetAttribute("part") && e->GetScalarAttribute("part", part) != 1)
      throw FileError(path, "DataSet " + std::to_string(i) + ": part '" + e->GetAttribute("part") +
                                "' is no number");
    const fs::path full = fs::path(path).parent_path() / file;
    if (!by_time[time].emplace(part, full.string()).second)
      throw FileError(path, "DataSet " + std::to_string(i) + ": part " + std::to_string(part) +
                                " of time " + std::to_string(time) + " is there twice");
  }
  if (by_time.empty())
    throw FileError(path, "holds no DataSet");
  std::vector<Step> steps;
  for (const auto& [time, parts] : by_time) {
    Step s;
    s.time = time;
    for (const auto& [part, file] : parts)
      s.files.push_back(file);
    steps.push_back(std::move(s));
  }
  return steps;
}

constexpr const char* extensions[] = {".vtu", ".vts", ".vtr", ".vti", ".vthb", ".vth", ".htg"};

void read_all_of(vtkXMLReader*) {}
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

/// The last number in a file's name, and the name without it.
std::pair<std::string, long long> numbered(const std::string& path) {
  const std::string name = fs::path(path).stem().string();
  std::size_t end = name.size();
  while (end > 0 && !std::isdigit(static_cast<unsigned char>(name[end - 1])))
    --end;
  std::size_t begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(name[begin - 1])))
    --begin;
  long long number = -1;
  std::from_chars(name.data() + begin, name.data() + end, number);
  return {name.substr(0, begin) + "#" + name.substr(end), number};
}

} // namespace

std::vector<Step> steps_of(const std::vector<std::string>& files) {
  std::vector<Step> steps;
  for (const std::string& file : files) {
    const std::string extension = fs::path(file).extension().string();
    if (extension == ".pvd") {
      for (Step& s : read_pvd(file))
        steps.push_back(std::move(s));
    } else if (std::find(std::begin(extensions), std::end(extensions), extension) !=
               std::end(extensions)) {
      require_readable(file);
      steps.push_back({{file}, {}});
    } else {
      throw FileError(file, "unknown kind of file; .vtu, .vts, .vtr, .vti, .vthb, .vth, .htg or "
                            ".pvd expected");
    }
  }
  return steps;
}

vtkSmartPointer<vtkDataObject> read(const std::string& path) {
  require_readable(path);
  if (window)
    window->first.clear();
  const std::string extension = fs::path(path).extension().string();
  const vtkSmartPointer<vtkDataObject> data =
      extension == ".htg"                           ? read_by<vtkXMLHyperTreeGridReader>(path)
      : extension == ".vthb" || extension == ".vth" ? read_by<vtkXMLUniformGridAMRReader>(path)
                                                    : read_by<vtkXMLGenericDataObjectReader>(path);
  const std::string message = first_message();
  if (!message.empty() ||
      !(vtkDataSet::SafeDownCast(data) || vtkOverlappingAMR::SafeDownCast(data) ||
        vtkHyperTreeGrid::SafeDownCast(data)))
    throw FileError(path, "cannot be read as a VTK XML data set" +
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

bool numbers_run_backwards(const std::vector<std::string>& files) {
  for (std::size_t i = 1; i < files.size(); ++i) {
    const auto before = numbered(files[i - 1]), now = numbered(files[i]);
    if (before.first == now.first && now.second < before.second)
      return true;
  }
  return false;
}

void silence_vtk() {
  static const vtkNew<QuietWindow> quiet;
  window = quiet;
  vtkOutputWindow::SetInstance(quiet);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

} // namespace insitu_replay
