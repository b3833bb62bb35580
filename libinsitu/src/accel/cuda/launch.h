#pragma once

#include <cstdint>

/// Numbers of launches; for .cu files.
namespace insitu::accel::cuda {

constexpr int threads_a_block = 256;

inline unsigned blocks_for(std::int64_t items, int threads = threads_a_block) {
  return unsigned((items + threads - 1) / threads);
}

__device__ inline std::int64_t global_thread() {
  return std::int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
}

} // namespace insitu::accel::cuda
