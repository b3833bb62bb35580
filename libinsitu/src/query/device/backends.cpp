#include "core/status.h"
#include "device/available.h"
#include "query/device/bvh_locator.h"
#include "query/device/device_locator.h"
#if defined(INSITU_HAVE_OPTIX)
#include "query/device/optix/locator.h"
#endif

namespace insitu::query {

using accel::Backend;

std::string why_unavailable(Backend backend) {
  if (backend == Backend::cpu)
    return "";
  std::string why = device::why_unavailable();
  if (backend == Backend::cuda || !why.empty())
    return why;
#if defined(INSITU_HAVE_OPTIX)
  return why_no_optix();
#else
  return "built without OptiX (configure with -DINSITU_OPTIX_ROOT=<SDK>)";
#endif
}

std::unique_ptr<DeviceLocator> make_device_locator(Backend backend, accel::Method method,
                                                   core::Memory& memory, std::int64_t group) {
  const auto refuse = [&](const std::string& why) {
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      std::string("backend ") + name(backend) + ": " + why);
  };
  if (backend == Backend::cpu || !has(backend, method))
    refuse(std::string("no method ") + name(method) + " on a device there");
  if (const std::string why = why_unavailable(backend); !why.empty())
    refuse(why);
#if defined(INSITU_HAVE_OPTIX)
  if (backend == Backend::optix)
    return make_optix_locator(method, memory, group);
#endif
  (void)group; // of ray methods alone
  return make_bvh_locator(memory);
}

} // namespace insitu::query
