#pragma once

#include "commands.h"

namespace insitu::bench {

/// Dual meshes of blocks and of random octrees by number of leaves: how build times go with them,
/// and what Zellmann 2023 has in tables 1 to 3.
Output measure_amr_sizes(const Options& options);

} // namespace insitu::bench
