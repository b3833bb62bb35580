#pragma once

#include <cstdint>

namespace insitu::bench {

/// Bytes that a program may still take without swapping: what the kernel says is available, less
/// where a control group allows less. 0: not known.
std::int64_t free_memory();

} // namespace insitu::bench
