#pragma once

#include "core/log.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "core/simd_target.h"

namespace insitu::core {

/// What a session shares with everything it runs.
struct Context {
  /// Throws core::Error if the environment names a SIMD target that is not there.
  Context(int thread_limit, const Log& session_log) : threads(thread_limit), log(session_log) {
    require_simd_target();
  }
  Memory memory; ///< first, so that it outlives what it counts
  Threads threads;
  Log log;
};

} // namespace insitu::core
