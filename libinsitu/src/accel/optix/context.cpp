#include "accel/optix/context.h"

#include <cuda_runtime_api.h>
#include <dlfcn.h>
#include <optix_function_table_definition.h>
#include <optix_stubs.h>
#include <utility>

#include "accel/optix/unavailable.h"
#include "core/status.h"

namespace insitu::accel::optix {
namespace {

/// Why optixInit failed. The stubs open the library themselves and tell little.
std::string why_not(OptixResult result) {
  if (result == OPTIX_ERROR_UNSUPPORTED_ABI_VERSION)
    return why_not_loaded(LoadFailure::driver_too_old, OPTIX_VERSION, OPTIX_ABI_VERSION, "");
  if (result != OPTIX_ERROR_LIBRARY_NOT_FOUND)
    return why_not_loaded(LoadFailure::other, OPTIX_VERSION, OPTIX_ABI_VERSION,
                          "result " + std::to_string(int(result)));
  std::string detail;
  if (void* library = dlopen("libnvoptix.so.1", RTLD_NOW | RTLD_LOCAL))
    dlclose(library);
  else if (const char* text = dlerror())
    detail = text;
  return why_not_loaded(LoadFailure::not_found, OPTIX_VERSION, OPTIX_ABI_VERSION, detail);
}

} // namespace

Context& Context::instance() {
  static Context* context = [] {
    auto* c = new Context;
    c->open();
    return c;
  }();
  return *context;
}

void Context::open() {
  int devices = 0;
  const cudaError_t found = cudaGetDeviceCount(&devices);
  if (found != cudaSuccess || devices == 0) {
    cudaGetLastError();
    why_not_ = std::string("no CUDA device: ") +
               (found == cudaSuccess ? "none is visible" : cudaGetErrorString(found));
    return;
  }
  if (const cudaError_t made = cudaFree(nullptr); made != cudaSuccess) { // the primary context
    why_not_ = std::string("no CUDA context: ") + cudaGetErrorString(made);
    return;
  }
  if (const OptixResult result = optixInit(); result != OPTIX_SUCCESS) {
    why_not_ = why_not(result);
    return;
  }
  OptixDeviceContextOptions options{};
  options.logCallbackFunction = &Context::log;
  options.logCallbackData = this;
  options.logCallbackLevel = 3; // fatal, errors, warnings
  const OptixResult made = optixDeviceContextCreate(nullptr, &options, &handle_);
  if (made != OPTIX_SUCCESS) {
    why_not_ = std::string("no OptiX context: ") + optixGetErrorName(made);
    return;
  }
  unsigned limit = 0;
  optixDeviceContextGetProperty(handle_, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_PRIMITIVES_PER_GAS, &limit,
                                sizeof limit);
  most_primitives_ = limit;
}

std::string Context::why_unavailable() {
  return instance().why_not_;
}

Context& Context::get() {
  Context& context = instance();
  if (!context.why_not_.empty())
    throw core::Error(INSITU_ERROR_UNSUPPORTED, "backend optix: " + context.why_not_);
  return context;
}

void Context::log(unsigned level, const char* tag, const char* message, void* context) {
  if (level > 3)
    return;
  Context& self = *static_cast<Context*>(context);
  std::lock_guard lock(self.mutex_);
  self.message_ = std::string(tag) + ": " + message;
  while (!self.message_.empty() && self.message_.back() == '\n')
    self.message_.pop_back();
}

std::string Context::take_message() {
  std::lock_guard lock(mutex_);
  return std::exchange(message_, {});
}

void check(OptixResult result, const std::string& action) {
  if (result == OPTIX_SUCCESS)
    return;
  std::string text = "OptiX, " + action + ": " + optixGetErrorName(result);
  if (const std::string message = Context::get().take_message(); !message.empty())
    text += " (" + message + ")";
  const bool memory =
      result == OPTIX_ERROR_DEVICE_OUT_OF_MEMORY || result == OPTIX_ERROR_HOST_OUT_OF_MEMORY;
  throw core::Error(memory ? INSITU_ERROR_MEMORY : INSITU_ERROR_INTERNAL, text);
}

} // namespace insitu::accel::optix
