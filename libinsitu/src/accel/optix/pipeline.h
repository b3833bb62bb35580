#pragma once

#include <cuda_runtime_api.h>
#include <optix.h>

#include "accel/optix/launch.h"

namespace insitu::accel::optix {

/// The programs of a method, compiled by the driver for one kind of question, with their binding
/// table. There is one of each kind a process, made at the first get() and never destroyed.
class Pipeline {
public:
  /// two_level: whether the structure has groups. Thread-safe; throws core::Error.
  static const Pipeline& get(Method method, Ask ask, bool two_level);

  /// Queues a launch of `count` rays. parameters: an optix::Launch in device memory, with this
  /// pipeline's method and ask.
  void launch(const void* parameters, std::uint32_t count, cudaStream_t stream) const;

private:
  Pipeline(Method method, Ask ask, bool two_level);
  void compile(Method method, Ask ask, bool two_level);
  void make_table();

  OptixProgramGroup groups_[3] = {}; ///< raygen, miss, hit
  OptixPipeline pipeline_ = nullptr;
  OptixShaderBindingTable table_ = {};
};

} // namespace insitu::accel::optix
