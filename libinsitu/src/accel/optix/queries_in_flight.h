#pragma once

#include <algorithm>
#include <cuda_runtime_api.h>
#include <vector>

#include "accel/cuda/device_buffer.h"

namespace insitu::accel::optix {

/// Streams on which queries were queued and not waited for: a commit must not change what they
/// read. One thread at a time.
class QueriesInFlight {
public:
  QueriesInFlight() = default;
  QueriesInFlight(const QueriesInFlight&) = delete;
  QueriesInFlight& operator=(const QueriesInFlight&) = delete;
  ~QueriesInFlight() {
    for (const Entry& e : entries_) {
      (void)cudaEventSynchronize(e.done);
      (void)cudaEventDestroy(e.done);
    }
  }

  /// All that is on the stream by now.
  void add(cudaStream_t stream) {
    auto at = std::find_if(entries_.begin(), entries_.end(),
                           [&](const Entry& e) { return e.stream == stream; });
    if (at == entries_.end()) {
      cudaEvent_t event;
      cuda::check(cudaEventCreateWithFlags(&event, cudaEventDisableTiming), "making an event");
      at = entries_.insert(at, {stream, event});
    }
    cuda::check(cudaEventRecord(at->done, stream), "recording an event");
  }
  void wait() {
    for (const Entry& e : entries_)
      cuda::check(cudaEventSynchronize(e.done), "waiting for queries");
  }

private:
  struct Entry {
    cudaStream_t stream;
    cudaEvent_t done;
  };
  std::vector<Entry> entries_;
};

} // namespace insitu::accel::optix
