#include "core/parallel.h"

#include <algorithm>

#if defined(__SANITIZE_THREAD__)
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#endif

#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include "core/float_environment.h"

namespace insitu::core {

#if defined(__SANITIZE_THREAD__)
namespace {

/// ThreadSanitizer does not see how the system's TBB, which is not built with it, hands work over
/// and waits for it. So that it judges our loops alone, it gets them on plain threads.
template <class Chunk>
void run_on_threads(int threads, std::int64_t chunks, const Chunk& chunk) {
  std::atomic<std::int64_t> next{0};
  std::exception_ptr first;
  std::mutex mutex;
  const auto work = [&] {
    FloatEnvironment environment;
    try {
      for (std::int64_t c = next++; c < chunks; c = next++)
        chunk(c);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!first)
        first = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (int t = 1; t < threads; ++t)
      others.emplace_back(work);
    work();
  }
  if (first)
    std::rethrow_exception(first);
}

} // namespace
#endif

struct Threads::Arena {
  explicit Arena(int n) : arena(n) {}
  tbb::task_arena arena;
};

// TBB's default concurrency already respects the process's affinity mask.
Threads::Threads(int limit)
    : count_(limit > 0 ? std::min(limit, tbb::info::default_concurrency())
                       : tbb::info::default_concurrency()) {
  if (count_ > 1)
    arena_ = std::make_unique<Arena>(count_);
}

Threads::~Threads() = default;

void Threads::parallel_for(std::int64_t n, std::int64_t grain,
                           FunctionRef<void(std::int64_t, std::int64_t)> body) const {
  if (n <= 0)
    return;
  grain = std::max<std::int64_t>(grain, 1);
  const std::int64_t chunks = (n + grain - 1) / grain;
  const auto chunk = [&](std::int64_t c) { body(c * grain, std::min(n, (c + 1) * grain)); };
  if (!arena_ || chunks == 1) {
    for (std::int64_t c = 0; c < chunks; ++c)
      chunk(c);
    return;
  }
#if defined(__SANITIZE_THREAD__)
  run_on_threads(count_, chunks, chunk);
#else
  arena_->arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::int64_t>(0, chunks, 1),
        [&](const tbb::blocked_range<std::int64_t>& range) {
          FloatEnvironment environment;
          for (std::int64_t c = range.begin(); c < range.end(); ++c)
            chunk(c);
        },
        tbb::simple_partitioner());
  });
#endif
}

void Threads::run(FunctionRef<void()> f) const {
  if (arena_)
    arena_->arena.execute([&] { f(); });
  else {
    // One thread: an arena of its own, since code inside f may start TBB tasks.
    tbb::task_arena single(1);
    single.execute([&] { f(); });
  }
}

} // namespace insitu::core
