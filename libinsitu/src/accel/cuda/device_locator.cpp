#include "accel/device_locator.h"

#include <cuda_runtime_api.h>

#include "accel/cuda/bvh_locator.h"
#include "accel/cuda/device_buffer.h"
#include "core/status.h"
#if defined(INSITU_HAVE_OPTIX)
#include "accel/optix/locator.h"
#endif

namespace insitu::accel {

namespace {

std::string version_text(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

std::string why_no_cuda() {
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

} // namespace

std::string why_unavailable(Backend backend) {
  if (backend == Backend::cpu)
    return "";
  std::string why = why_no_cuda();
  if (backend == Backend::cuda || !why.empty())
    return why;
#if defined(INSITU_HAVE_OPTIX)
  return why_no_optix();
#else
  return "built without OptiX (configure with -DINSITU_OPTIX_ROOT=<SDK>)";
#endif
}

void copy_from_device(std::byte* to, const std::byte* from, std::size_t bytes) {
  cuda::check(cudaMemcpy(to, from, bytes, cudaMemcpyDeviceToHost), "copying from the device");
}

std::unique_ptr<DeviceLocator> make_device_locator(Backend backend, Method method,
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
  return cuda::make_bvh_locator(memory);
}

void DeviceLocator::advance(const DeviceTracers&) const {
  throw core::Error(INSITU_ERROR_UNSUPPORTED, "tracers on the device: backend cuda has them");
}

} // namespace insitu::accel
