// The device of a build without CUDA.
#include "core/device_memory.h"
#include "core/status.h"
#include "device/available.h"

bool insitu::core::device_memory_supported() {
  return false;
}

std::string insitu::device::why_unavailable() {
  return "built without CUDA (configure with -DINSITU_WITH_CUDA=ON)";
}

void insitu::device::copy_from_device(std::byte*, const std::byte*, std::size_t) {
  throw core::Error(INSITU_ERROR_UNSUPPORTED, "device memory: " + why_unavailable());
}
