#pragma once

#include <mutex>
#include <optional>

#include "mesh/facts.h"

namespace insitu::query {

/// The facts of a committed mesh, found when somebody first asks.
class FactsCache {
public:
  /// Thread-safe. threads: null: on the calling thread; the answer does not depend on them.
  mesh::MeshFacts of(const mesh::MeshView& mesh, const core::Threads* threads) const {
    {
      const std::lock_guard lock(mutex_);
      if (facts_)
        return *facts_;
    }
    // Without the lock: a thread that waits for others may be given a task that asks as well.
    mesh::MeshFacts found = mesh::find_facts(mesh, threads);
    const std::lock_guard lock(mutex_);
    return *(facts_ = std::move(found));
  }
  /// The cells or their vertices changed; nobody asks meanwhile.
  void forget() { facts_.reset(); }

private:
  mutable std::mutex mutex_;
  mutable std::optional<mesh::MeshFacts> facts_;
};

} // namespace insitu::query
