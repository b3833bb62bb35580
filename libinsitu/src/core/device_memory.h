#pragma once

namespace insitu::core {

// Whether this build reads arrays that lie in a device's memory. The module accel defines the
// function with its device backends or without these, so that no object beside accel's differs
// between builds with and without CUDA.
bool device_memory_supported();

} // namespace insitu::core
