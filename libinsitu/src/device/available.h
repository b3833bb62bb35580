#pragma once

#include <cstddef>
#include <string>

/// What the host asks of a device whether the library was built with CUDA or without it.
namespace insitu::device {

/// Empty if a CUDA device can be used here, else why not ("no CUDA device: ...", "built without
/// CUDA ...").
std::string why_unavailable();

/// Copies from device memory to the host's; returns when done. Throws core::Error.
void copy_from_device(std::byte* to, const std::byte* from, std::size_t bytes);

} // namespace insitu::device
