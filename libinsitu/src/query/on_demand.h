#pragma once

#include <atomic>
#include <mutex>

#include "core/parallel.h"
#include "query/facts_cache.h"
#include "query/lone_cells.h"
#include "query/sound_cells.h"
#include "query/walk/number_steps.h"

namespace insitu::query {

/// Work of a commit that waits until somebody needs it. All calls but complete() are the
/// committer's, while nobody asks.
class PutOff {
public:
  virtual ~PutOff() = default;
  bool is_due() const { return due_.load(std::memory_order_acquire); }
  /// Does the work if it is due. Thread-safe: the first caller does it, and the others wait. What
  /// it throws reaches the caller, and the work stays due.
  void complete() const {
    if (!is_due())
      return;
    const std::lock_guard lock(mutex_);
    if (!due_.load(std::memory_order_relaxed))
      return;
    do_it();
    due_.store(false, std::memory_order_release);
  }

protected:
  void set_due(bool due) { due_.store(due, std::memory_order_release); }
  /// Runs in a task of the caller's, who may hold a thread that others wait for: so it uses no
  /// threads of a session's but an arena of its own.
  virtual void do_it() const = 0;

private:
  mutable std::mutex mutex_;
  mutable std::atomic<bool> due_{false};
};

/// What a committed mesh finds out when it is first asked for it.
struct OnDemand {
  const PutOff* tree = nullptr;         ///< the fit of its boxes to vertices that moved
  const PutOff* displacement = nullptr; ///< MeshView::largest_displacement
  FactsCache facts;
  NumberStepsCache steps;
  const SoundCells* sound = nullptr;
  const LoneCells* lone = nullptr;
};

} // namespace insitu::query
