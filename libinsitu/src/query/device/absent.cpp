// The locators on devices of a build without CUDA.
#include "core/status.h"
#include "query/device/device_locator.h"

namespace insitu::query {

using accel::Backend;

std::string why_unavailable(Backend backend) {
  return backend == Backend::cpu
             ? ""
             : std::string("built without CUDA (configure with -DINSITU_WITH_CUDA=ON") +
                   (backend == Backend::optix ? " and -DINSITU_OPTIX_ROOT=<SDK>)" : ")");
}

std::unique_ptr<DeviceLocator> make_device_locator(Backend backend, accel::Method, core::Memory&,
                                                   std::int64_t) {
  throw core::Error(INSITU_ERROR_UNSUPPORTED,
                    std::string("backend ") + name(backend) + ": " + why_unavailable(backend));
}

} // namespace insitu::query
