#pragma once

#include <compare>
#include <cuda_runtime_api.h>
#include <optix.h>

#include "query/device/optix/launch.h"

namespace insitu::query::optix {

/// What a pipeline is compiled for.
struct Variant {
  accel::Method method;
  Ask ask;
  mesh::Shape shape; ///< of all cells: a tetrahedron, a hexahedron, or none
  bool two_level;    ///< whether the structure has groups
  auto operator<=>(const Variant&) const = default;
};

/// The programs of a method, compiled by the driver for one kind of question, with their binding
/// table. There is one of each kind a process, made at the first get() and never destroyed.
class Pipeline {
public:
  /// Thread-safe; throws core::Error.
  static const Pipeline& get(const Variant& variant);

  /// Queues a launch of `count` rays. parameters: an optix::Launch in device memory, with this
  /// variant's values.
  void launch(const void* parameters, std::uint32_t count, cudaStream_t stream) const;

private:
  explicit Pipeline(const Variant& variant);
  void compile(const Variant& variant);
  void make_table();

  OptixProgramGroup groups_[3] = {}; ///< raygen, miss, hit
  OptixPipeline pipeline_ = nullptr;
  OptixShaderBindingTable table_ = {};
};

} // namespace insitu::query::optix
