#pragma once

#include <string>
#include <vector>

#include "compare/verdict.h"

namespace insitu::compare {

struct NetcdfOptions {
  Tolerance tolerance;
  std::vector<NamedTolerance> variables;
  /// Variables, with their attributes; or attributes alone: "variable:attribute", ":attribute" of
  /// the file.
  std::vector<std::string> ignored;
  /// Names that neither file has are passed over rather than an error.
  bool lenient = false;
};

/// Compares two netCDF files (of any format that netCDF-C reads): dimensions, attributes, and the
/// values of variables of the same name. Texts are compared as texts; not-a-number equals itself.
/// Where the files differ in the length of the unlimited dimension, the records that both have are
/// compared. For each variable that moved, a line tells in how many values and where most. Throws
/// core::Error (INSITU_ERROR_FILE) naming the file that cannot be read, or the variable whose type
/// is neither a number nor text.
Verdict compare_netcdf(const std::string& a, const std::string& b, const NetcdfOptions& options);

} // namespace insitu::compare
