#pragma once

#include <cuda_runtime_api.h>

/// Errors of CUDA's calls; for files that call CUDA themselves.
namespace insitu::device {

/// Throws core::Error unless the call succeeded: INSITU_ERROR_MEMORY with the device's free and
/// total bytes where memory ran out, else INSITU_ERROR_UNSUPPORTED. what: the action that failed,
/// such as "copying points".
void check(cudaError_t status, const char* what);

} // namespace insitu::device
