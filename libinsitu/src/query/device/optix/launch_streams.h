#pragma once

#include <cuda_runtime_api.h>
#include <vector>

#include "device/buffer.h"
#include "query/device/optix/launch.h"

namespace insitu::query::optix {

/// The streams on which launches were queued, each with memory for a launch's parameters: a stream
/// runs in order, so the next launch may overwrite those of the one before. One thread at a time.
class LaunchStreams {
public:
  explicit LaunchStreams(core::Memory& memory) : memory_(&memory) {}
  LaunchStreams(const LaunchStreams&) = delete;
  LaunchStreams& operator=(const LaunchStreams&) = delete;
  ~LaunchStreams();

  /// Queues a copy of a launch's parameters; returns where on the device they are.
  const Launch* put(const Launch& parameters, cudaStream_t stream);
  /// The launch that reads them has been queued.
  void launched(cudaStream_t stream);
  std::int64_t bytes() const;

private:
  struct Entry {
    cudaStream_t stream;
    cudaEvent_t done;
    device::Buffer<Launch> parameters;
  };
  Entry& find(cudaStream_t stream);
  void clear() noexcept;

  static constexpr std::size_t most = 64; ///< streams that are remembered
  core::Memory* memory_;
  std::vector<Entry> entries_;
};

} // namespace insitu::query::optix
