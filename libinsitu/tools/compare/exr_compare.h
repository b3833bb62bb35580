#pragma once

#include <string>
#include <vector>

#include "compare/verdict.h"

namespace insitu::compare {

struct ExrOptions {
  Tolerance tolerance = {};
  std::vector<NamedTolerance> channels = {}; ///< other tolerances
  std::vector<std::string> ignored = {};     ///< channels
  double max_share = 0; ///< of the pixels, from 0 to 1, that may differ by more in a channel
};

/// OpenEXR files: channels are matched by name and compared as numbers, whole ones as well.
/// Attributes say where an image is from, and are passed over. Throws core::Error
/// (INSITU_ERROR_FILE) for what cannot be read.
Verdict compare_exr(const std::string& a, const std::string& b, const ExrOptions& options);

} // namespace insitu::compare
