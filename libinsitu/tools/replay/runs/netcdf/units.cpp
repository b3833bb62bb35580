#include "runs/netcdf/units.h"

#include <utility>

namespace insitu_replay {

namespace {

/// The spellings that the CF conventions allow begin alike.
bool is_angle(const NetcdfFile& file, const NetcdfFile::Variable& v, const char* way,
              const char* name) {
  const std::string units = file.text(v, "units");
  return units.starts_with("degrees_" + std::string(way)) ||
         units.starts_with("degree_" + std::string(way)) ||
         units == (*way == 'e' ? "degreesE" : "degreesN") ||
         units == (*way == 'e' ? "degreeE" : "degreeN") ||
         (file.text(v, "standard_name") == name && (units.empty() || units.starts_with("degree")));
}

} // namespace

std::optional<double> metres_of(const std::string& unit) {
  for (const auto& [name, metres] : {std::pair{"m", 1.0},
                                     {"metre", 1.0},
                                     {"metres", 1.0},
                                     {"meter", 1.0},
                                     {"meters", 1.0},
                                     {"km", 1000.0},
                                     {"kilometre", 1000.0},
                                     {"kilometres", 1000.0},
                                     {"kilometer", 1000.0},
                                     {"kilometers", 1000.0},
                                     {"cm", 0.01}})
    if (unit == name)
      return metres;
  return std::nullopt;
}

bool is_longitude(const NetcdfFile& file, const NetcdfFile::Variable& v) {
  return is_angle(file, v, "e", "longitude");
}

bool is_latitude(const NetcdfFile& file, const NetcdfFile::Variable& v) {
  return is_angle(file, v, "n", "latitude");
}

} // namespace insitu_replay
