#include "device/available.h"

#include "core/device_memory.h"
#include "device/check.h"

bool insitu::core::device_memory_supported() {
  return true;
}

namespace insitu::device {

namespace {

std::string version_text(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

} // namespace

std::string why_unavailable() {
  int driver = 0, runtime = 0, devices = 0;
  (void)cudaRuntimeGetVersion(&runtime);
  if (cudaDriverGetVersion(&driver) != cudaSuccess || driver == 0)
    return "no CUDA driver";
  const cudaError_t status = cudaGetDeviceCount(&devices);
  (void)cudaGetLastError();
  if (status == cudaErrorInsufficientDriver)
    return "the driver is for CUDA " + version_text(driver) + ", too old for this build's CUDA " +
           version_text(runtime);
  if (status != cudaSuccess || devices == 0)
    return std::string("no CUDA device: ") +
           (status == cudaSuccess ? "none found" : cudaGetErrorString(status));
  return "";
}

void copy_from_device(std::byte* to, const std::byte* from, std::size_t bytes) {
  check(cudaMemcpy(to, from, bytes, cudaMemcpyDeviceToHost), "copying from the device");
}

} // namespace insitu::device
