#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace insitu_replay {

/// Reads a list of labels, as OpenFOAM writes one to a file of its own: as text or in binary form.
/// Throws FileError.
std::vector<std::int64_t> read_foam_labels(const std::string& path);

} // namespace insitu_replay
