#pragma once

#include <optional>
#include <string>

#include "runs/netcdf/netcdf_file.h"

namespace insitu_replay {

/// Metres in a unit of length.
std::optional<double> metres_of(const std::string& unit);

/// Whether a variable is in degrees of longitude or of latitude.
bool is_longitude(const NetcdfFile& file, const NetcdfFile::Variable& v);
bool is_latitude(const NetcdfFile& file, const NetcdfFile::Variable& v);

} // namespace insitu_replay
