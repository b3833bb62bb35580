#include "query/locator_choice.h"

#include "core/status.h"
#include "query/device/device_locator.h"

namespace insitu::query {

using accel::Backend;
using accel::Method;

namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw core::Error(INSITU_ERROR_UNSUPPORTED, "locator: " + what);
}

/// Throws unless the backend can be used here.
void require(Backend backend) {
  if (const std::string why = why_unavailable(backend); !why.empty())
    refuse(std::string("backend ") + name(backend) + ": " + why);
}

Backend only_backend(const LocatorChoice& choice, Method method) {
  if (!has(*choice.backend, method))
    refuse(std::string("method ") + name(method) + " is not on backend " + name(*choice.backend) +
           (method == Method::bvh ? "; cpu and cuda have it" : "; cpu and optix have it"));
  require(*choice.backend);
  return *choice.backend;
}

/// The automatic backend of a mesh in device memory, which only a device can read.
LocatorPick pick_on_device(const LocatorChoice& choice) {
  const Method method = choice.method.value_or(Method::bvh);
  const Backend backend = method == Method::bvh ? Backend::cuda : Backend::optix;
  require(backend);
  return {method, backend, "the mesh lies in device memory", ""};
}

} // namespace

LocatorPick pick_locator(const LocatorChoice& choice, bool on_device) {
  if (choice.backend) {
    // With a backend alone: bvh where it is; of OptiX's methods the one that is right for curved
    // faces too.
    const Method method = choice.method.value_or(
        *choice.backend == Backend::optix ? Method::shared_bilinear_faces : Method::bvh);
    const Backend backend = only_backend(choice, method);
    if (on_device && backend == Backend::cpu)
      refuse("backend cpu cannot read a mesh in device memory");
    return {method, backend, choice.method ? "as asked for" : "the backend's method for any cells",
            ""};
  }
  if (on_device)
    return pick_on_device(choice);
  if (!choice.method)
    return {Method::bvh, Backend::cpu, "the mesh lies in host memory; bvh is fastest on a CPU", ""};
  if (*choice.method == Method::bvh)
    return {Method::bvh, Backend::cpu, "the mesh lies in host memory", ""};
  const std::string why = why_unavailable(Backend::optix);
  if (why.empty())
    return {*choice.method, Backend::optix, "ray methods run on OptiX where it can be used", ""};
  return {*choice.method, Backend::cpu, "no OptiX here: Embree",
          std::string("locator ") + name(*choice.method) + ": no OptiX (" + why +
              "); Embree answers"};
}

} // namespace insitu::query
