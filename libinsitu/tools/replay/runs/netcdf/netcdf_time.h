#pragma once

#include <string>
#include <vector>

#include "runs/netcdf/netcdf_file.h"

namespace insitu_replay {

/// The time of a netCDF file, in seconds from the date that its units name.
struct NetcdfTime {
  int dim = -1;                                     ///< -1: the file knows no time
  const NetcdfFile::Variable* coordinate = nullptr; ///< null: the file has none
  /// In the order of the file; places where the file has no coordinate.
  std::vector<double> values;
  double unit = 1;  ///< seconds in one of the file's units
  std::string note; ///< of units that are not known, whose numbers stay as they are
};

/// Finds the time by its units ("days since ..."), or else by its name, or else takes the unlimited
/// dimension's places.
NetcdfTime netcdf_time_of(const NetcdfFile& file);

} // namespace insitu_replay
