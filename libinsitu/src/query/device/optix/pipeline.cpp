#include "query/device/optix/pipeline.h"

#include <cstddef>
#include <map>
#include <mutex>
#include <optix_stack_size.h>
#include <optix_stubs.h>

#include "accel/optix/context.h"
#include "device/check.h"
#include "device/memory.h"
#include "query/device/optix/programs.inc" // programs.cu in OptiX-IR, as an array

namespace insitu::query::optix {

using accel::Method;
using accel::optix::check;
using accel::optix::Context;

namespace {

/// A record of the binding table: its programs, no data of its own.
struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) Record {
  char header[OPTIX_SBT_RECORD_HEADER_SIZE];
};

OptixPipelineCompileOptions pipeline_options(const Variant& variant) {
  OptixPipelineCompileOptions options{};
  options.traversableGraphFlags = variant.two_level
                                      ? OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING
                                      : OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
  options.numPayloadValues = 1;   // the cell
  options.numAttributeValues = 2; // a triangle's own, the least
  options.exceptionFlags = OPTIX_EXCEPTION_FLAG_NONE;
  options.pipelineLaunchParamsVariableName = "launch_parameters";
  options.usesPrimitiveTypeFlags = variant.method == Method::user_geometry
                                       ? OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM
                                       : OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE;
  return options;
}

OptixModule make_module(const Variant& variant, const OptixPipelineCompileOptions& pipeline) {
  const auto method = std::uint32_t(variant.method), ask = std::uint32_t(variant.ask),
             shape = std::uint32_t(variant.shape);
  const OptixModuleCompileBoundValueEntry bound[] = {
      {offsetof(Launch, method), sizeof method, &method, "method"},
      {offsetof(Launch, ask), sizeof ask, &ask, "ask"},
      {offsetof(Launch, shape), sizeof shape, &shape, "shape"}};
  OptixModuleCompileOptions options{};
  options.optLevel = OPTIX_COMPILE_OPTIMIZATION_DEFAULT;
  options.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_NONE;
  options.boundValues = bound;
  options.numBoundValues = 3;
  char log[2048];
  std::size_t log_size = sizeof log;
  OptixModule module = nullptr;
  check(optixModuleCreate(Context::get().handle(), &options, &pipeline,
                          reinterpret_cast<const char*>(optix_programs), sizeof optix_programs, log,
                          &log_size, &module),
        std::string("compiling the programs of ") + name(variant.method));
  return module;
}

} // namespace

const Pipeline& Pipeline::get(const Variant& variant) {
  static std::mutex mutex;
  static auto& made = *new std::map<Variant, const Pipeline*>;
  std::lock_guard lock(mutex);
  const Pipeline*& pipeline = made[variant];
  if (!pipeline)
    pipeline = new Pipeline(variant);
  return *pipeline;
}

Pipeline::Pipeline(const Variant& variant) {
  compile(variant);
  make_table();
}

void Pipeline::compile(const Variant& variant) {
  OptixDeviceContext context = Context::get().handle();
  const Method method = variant.method;
  const OptixPipelineCompileOptions options = pipeline_options(variant);
  OptixModule module = make_module(variant, options);

  OptixProgramGroupDesc kinds[3] = {};
  kinds[0].kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
  kinds[0].raygen = {module, "__raygen__query"};
  kinds[1].kind = OPTIX_PROGRAM_GROUP_KIND_MISS; // no program: the payload stays as it was
  kinds[2].kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
  if (method == Method::user_geometry) {
    kinds[2].hitgroup.moduleIS = module;
    kinds[2].hitgroup.entryFunctionNameIS = "__intersection__cell";
  } else {
    kinds[2].hitgroup.moduleCH = module;
    kinds[2].hitgroup.entryFunctionNameCH = "__closesthit__face";
  }
  const OptixProgramGroupOptions group_options{};
  char log[2048];
  std::size_t log_size = sizeof log;
  check(optixProgramGroupCreate(context, kinds, 3, &group_options, log, &log_size, groups_),
        std::string("making the program groups of ") + name(method));

  OptixPipelineLinkOptions link{};
  link.maxTraceDepth = 1;
  log_size = sizeof log;
  check(optixPipelineCreate(context, &options, &link, groups_, 3, log, &log_size, &pipeline_),
        std::string("linking the programs of ") + name(method));

  OptixStackSizes sizes{};
  for (OptixProgramGroup group : groups_)
    check(optixUtilAccumulateStackSizes(group, &sizes, pipeline_), "asking for stack sizes");
  unsigned from_traversal = 0, from_state = 0, continuation = 0;
  check(optixUtilComputeStackSizes(&sizes, 1, 0, 0, &from_traversal, &from_state, &continuation),
        "computing stack sizes");
  check(optixPipelineSetStackSize(pipeline_, from_traversal, from_state, continuation,
                                  variant.two_level ? 2 : 1),
        "setting stack sizes");
}

void Pipeline::make_table() {
  Record records[3];
  for (int g = 0; g < 3; ++g)
    check(optixSbtRecordPackHeader(groups_[g], &records[g]), "packing the binding table");
  void* on_device = device::allocate(sizeof records); // the process's, as the pipeline is
  device::check(cudaMemcpy(on_device, records, sizeof records, cudaMemcpyHostToDevice),
                "copying the binding table");
  const auto base = reinterpret_cast<CUdeviceptr>(on_device);
  table_.raygenRecord = base;
  table_.missRecordBase = base + sizeof(Record);
  table_.missRecordStrideInBytes = sizeof(Record);
  table_.missRecordCount = 1;
  table_.hitgroupRecordBase = base + 2 * sizeof(Record);
  table_.hitgroupRecordStrideInBytes = sizeof(Record);
  table_.hitgroupRecordCount = 1;
}

void Pipeline::launch(const void* parameters, std::uint32_t count, cudaStream_t stream) const {
  check(optixLaunch(pipeline_, stream, reinterpret_cast<CUdeviceptr>(parameters), sizeof(Launch),
                    &table_, count, 1, 1),
        "launching " + std::to_string(count) + " rays");
}

} // namespace insitu::query::optix
