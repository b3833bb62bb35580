#include "runs/netcdf/netcdf_time.h"

#include <optional>
#include <utility>

namespace insitu_replay {

namespace {

using Variable = NetcdfFile::Variable;

constexpr std::pair<const char*, double> units[] = {
    {"s", 1},       {"sec", 1},      {"secs", 1},      {"second", 1},    {"seconds", 1},
    {"min", 60},    {"mins", 60},    {"minute", 60},   {"minutes", 60},  {"h", 3600},
    {"hr", 3600},   {"hrs", 3600},   {"hour", 3600},   {"hours", 3600},  {"d", 86400},
    {"day", 86400}, {"days", 86400}, {"week", 604800}, {"weeks", 604800}};

std::optional<double> seconds_of(const std::string& word) {
  for (const auto& [name, seconds] : units)
    if (word == name)
      return seconds;
  return std::nullopt;
}

/// A variable over one dimension whose units tell a date, or else which is the axis of time; of
/// several that which has the dimension's name.
const Variable* coordinate_of(const NetcdfFile& file) {
  const Variable *dated = nullptr, *axis = nullptr;
  for (const Variable& v : file.variables()) {
    if (v.dims.size() != 1 || !NetcdfFile::has_numbers(v))
      continue;
    const bool has_name = v.name == file.name_of_dim(v.dims[0]);
    if (file.text(v, "units").find(" since ") != std::string::npos && (!dated || has_name))
      dated = &v;
    else if (has_name && (file.is_unlimited(v.dims[0]) || v.name == "time" ||
                          file.text(v, "standard_name") == "time" || file.text(v, "axis") == "T"))
      axis = &v;
  }
  return dated ? dated : axis;
}

} // namespace

NetcdfTime netcdf_time_of(const NetcdfFile& file) {
  NetcdfTime out;
  if (const Variable* const v = coordinate_of(file)) {
    out.dim = v->dims[0];
    out.values = file.values(*v);
    const std::vector<std::string> words = file.words(*v, "units");
    const std::optional<double> seconds = seconds_of(words.empty() ? "seconds" : words[0]);
    out.unit = seconds.value_or(1);
    if (!seconds)
      out.note = "variable '" + v->name + "': times stay in units of '" + words[0] +
                 "', which have no fixed length in seconds";
    for (double& value : out.values)
      value *= out.unit;
    out.coordinate = v;
    return out;
  }
  for (const Variable& v : file.variables())
    for (const int dim : v.dims)
      if (out.dim < 0 && file.is_unlimited(dim)) {
        out.dim = dim;
        for (std::size_t i = 0; i < file.length(dim); ++i)
          out.values.push_back(double(i));
      }
  return out;
}

} // namespace insitu_replay
