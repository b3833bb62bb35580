#pragma once

#include <string>

#include "options.h"

namespace insitu::bench {

/// Dual meshes of blocks and of random octrees by number of leaves: how build times go with them,
/// and what Zellmann 2023 has in tables 1 to 3.
struct AmrSizes {
  std::string text;
  std::string json; ///< members of an object, a line each, with a comma behind each
};
AmrSizes measure_amr_sizes(const Options& options);

} // namespace insitu::bench
