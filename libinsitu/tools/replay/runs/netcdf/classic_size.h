#pragma once

#include <string>

namespace insitu_replay {

/// Throws FileError, with a variable's name, for a file of netCDF's classic formats that ends
/// before the values of a variable do: the library reads zeros there. Other files pass.
void require_whole_netcdf(const std::string& path);

} // namespace insitu_replay
