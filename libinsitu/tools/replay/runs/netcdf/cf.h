#pragma once

#include <memory>
#include <string>

#include "runs/run.h"

namespace insitu_replay {

/// A netCDF file by the CF conventions, by VTK's reader: longitudes and latitudes as they are,
/// depths as heights; times in seconds. Throws FileError.
std::unique_ptr<Run> open_cf(const std::string& path);

} // namespace insitu_replay
