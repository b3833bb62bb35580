#include "query/device/optix/launch_streams.h"

#include <algorithm>

#include "device/check.h"

namespace insitu::query::optix {

LaunchStreams::~LaunchStreams() {
  clear();
}

void LaunchStreams::clear() noexcept {
  for (const Entry& e : entries_) {
    (void)cudaEventSynchronize(e.done);
    (void)cudaEventDestroy(e.done);
  }
  entries_.clear();
}

LaunchStreams::Entry& LaunchStreams::find(cudaStream_t stream) {
  const auto at = std::find_if(entries_.begin(), entries_.end(),
                               [&](const Entry& e) { return e.stream == stream; });
  if (at != entries_.end())
    return *at;
  if (entries_.size() >= most)
    clear();
  cudaEvent_t event;
  device::check(cudaEventCreateWithFlags(&event, cudaEventDisableTiming), "making an event");
  return entries_.emplace_back(Entry{stream, event, device::Buffer<Launch>(*memory_)});
}

const Launch* LaunchStreams::put(const Launch& parameters, cudaStream_t stream) {
  Entry& entry = find(stream);
  entry.parameters.resize_discard(1);
  // Another stream may have had this handle before.
  device::check(cudaStreamWaitEvent(stream, entry.done, 0), "waiting for a launch");
  // From pageable memory: it has been read when the call returns.
  device::copy_to_device(entry.parameters.data(), &parameters, sizeof parameters, stream,
                         "copying a launch");
  return entry.parameters.data();
}

void LaunchStreams::launched(cudaStream_t stream) {
  device::check(cudaEventRecord(find(stream).done, stream), "recording an event");
}

std::int64_t LaunchStreams::bytes() const {
  std::int64_t sum = 0;
  for (const Entry& e : entries_)
    sum += e.parameters.bytes();
  return sum;
}

} // namespace insitu::query::optix
