// The device backends of a build without CUDA.
#include "accel/device_locator.h"
#include "core/device_memory.h"
#include "core/status.h"

bool insitu::core::device_memory_supported() {
  return false;
}

namespace insitu::accel {

std::string why_unavailable(Backend backend) {
  return backend == Backend::cpu
             ? ""
             : std::string("built without CUDA (configure with -DINSITU_WITH_CUDA=ON") +
                   (backend == Backend::optix ? " and -DINSITU_OPTIX_ROOT=<SDK>)" : ")");
}

void copy_from_device(std::byte*, const std::byte*, std::size_t) {
  throw core::Error(INSITU_ERROR_UNSUPPORTED, "device memory: " + why_unavailable(Backend::cuda));
}

std::unique_ptr<DeviceLocator> make_device_locator(Backend backend, Method, core::Memory&,
                                                   std::int64_t) {
  throw core::Error(INSITU_ERROR_UNSUPPORTED,
                    std::string("backend ") + name(backend) + ": " + why_unavailable(backend));
}

void DeviceLocator::advance(const DeviceTracers&) const {
  throw core::Error(INSITU_ERROR_UNSUPPORTED, "tracers on the device: backend cuda has them");
}

} // namespace insitu::accel
