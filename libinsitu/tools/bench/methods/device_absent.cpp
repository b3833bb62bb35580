// Builds without CUDA: query::why_unavailable says so before these are called.
#include <stdexcept>

#include "methods/runner.h"

namespace insitu::bench {

std::unique_ptr<MethodRunner> make_device_runner(accel::Backend, accel::Method, MethodMesh&,
                                                 core::Context&) {
  throw std::runtime_error("built without CUDA");
}

std::string device_name() {
  return "";
}

} // namespace insitu::bench
