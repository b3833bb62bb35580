#pragma once

#include <cstdint>

#include "device/stream.h"
#include "math/hd.h"
#if defined(__CUDACC__)
#include "device/check.h"
#elif !defined(INSITU_DEVICE_ON_HOST)
#error "Files that start kernels are compiled by CUDA's compiler, or for the host by tests."
#endif

/// The one way in which kernels are started. A kernel is an object with `INSITU_HD void
/// operator()(std::int64_t i) const`, copied to the device, and does item i of n. CUDA's compiler
/// makes a grid of one thread an item. A build with INSITU_DEVICE_ON_HOST makes a loop in the
/// calling thread, so that tests run the same text without a card.
namespace insitu::device {

constexpr int threads_a_block = 256;

#if defined(__CUDACC__)

template <int block, class Kernel>
__global__ void __launch_bounds__(block)
    run(const __grid_constant__ Kernel kernel, std::int64_t count) {
  const std::int64_t i = std::int64_t(blockIdx.x) * block + threadIdx.x;
  if (i < count)
    kernel(i);
}

/// Queues kernel(0) to kernel(count - 1) on the stream, in any order. what: the action that a
/// message names if the launch fails.
template <int block = threads_a_block, class Kernel>
void launch(std::int64_t count, const Kernel& kernel, StreamHandle stream, const char* what) {
  if (count == 0)
    return;
  run<block><<<unsigned((count + block - 1) / block), block, 0, stream>>>(kernel, count);
  check(cudaGetLastError(), what);
}

#else

template <int block = threads_a_block, class Kernel>
void launch(std::int64_t count, const Kernel& kernel, StreamHandle, const char*) {
  for (std::int64_t i = 0; i < count; ++i)
    kernel(i);
}

#endif

} // namespace insitu::device
