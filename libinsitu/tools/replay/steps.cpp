#include "steps.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>
#include <yaml-cpp/yaml.h>

#include "read.h"
#include "runs/runs_of_others.h"

namespace insitu_replay {

namespace fs = std::filesystem;

namespace {

/// A file that an index names.
void require_kind(const std::string& file, const std::string& index) {
  if (!is_readable_kind(file))
    throw FileError(index, "names " + file + ", an unknown kind of file; " + readable_kinds +
                               " expected, of these no index");
}

std::vector<Step> read_pvd(const std::string& path) {
  require_readable(path);
  forget_messages();
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
    require_kind(full.string(), path);
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

/// ParaView's index of a series, JSON, of which YAML is a superset:
/// {"file-series-version": "1.0", "files": [{"name": "a.vtu", "time": 0}]}
std::vector<Step> read_series(const std::string& path) {
  require_readable(path);
  std::vector<Step> steps;
  try {
    const YAML::Node files = YAML::LoadFile(path)["files"];
    if (!files || !files.IsSequence())
      throw FileError(path, "is no .series index: no list 'files'");
    for (const YAML::Node& file : files) {
      const std::string entry = "entry " + std::to_string(steps.size());
      if (!file.IsMap() || !file["name"])
        throw FileError(path, entry + " names no file");
      const fs::path full = fs::path(path).parent_path() / file["name"].as<std::string>();
      require_kind(full.string(), path);
      const double time = file["time"] ? file["time"].as<double>() : double(steps.size());
      if (!std::isfinite(time))
        throw FileError(path, entry + ": time is not finite");
      steps.push_back({{full.string()}, time, false});
    }
  } catch (const YAML::Exception& e) {
    throw FileError(path, std::string("is no .series index: ") + e.what());
  }
  if (steps.empty())
    throw FileError(path, "names no file");
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) {
    return *a.time != *b.time ? *a.time < *b.time : a.files < b.files;
  });
  return steps;
}

/// All steps of a run in one file, or the one of a file that knows no time.
std::vector<Step> steps_of_run(const std::string& path) {
  std::vector<Step> steps;
  for (const double time : times_of_run(path))
    steps.push_back({{path}, time, true});
  if (steps.empty())
    steps.push_back({{path}, {}, true});
  return steps;
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
    const std::string ending = ending_of(file);
    if (ending == ".pvd" || ending == ".series") {
      for (Step& s : ending == ".pvd" ? read_pvd(file) : read_series(file))
        steps.push_back(std::move(s));
    } else if (holds_a_run(file)) {
      for (Step& s : steps_of_run(file))
        steps.push_back(std::move(s));
    } else if (is_readable_kind(file)) {
      require_readable(file);
      steps.push_back({{file}, {}, false});
    } else {
      throw FileError(file, std::string("unknown kind of file; ") + readable_kinds + ", " +
                                run_kinds + " expected");
    }
  }
  return steps;
}

bool numbers_run_backwards(const std::vector<std::string>& files) {
  for (std::size_t i = 1; i < files.size(); ++i) {
    const auto before = numbered(files[i - 1]), now = numbered(files[i]);
    if (before.first == now.first && now.second < before.second)
      return true;
  }
  return false;
}

} // namespace insitu_replay
