#pragma once

#include "core/log.h"
#include "core/memory.h"
#include "core/parallel.h"

namespace insitu::core {

/// What a session shares with everything it runs.
struct Context {
  Context(int thread_limit, const Log& session_log) : threads(thread_limit), log(session_log) {}
  Memory memory; ///< first, so that it outlives what it counts
  Threads threads;
  Log log;
};

} // namespace insitu::core
