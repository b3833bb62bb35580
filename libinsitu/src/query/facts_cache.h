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
  /// Those of the whole mesh, where it is spread over processes; to the next forget(), and nobody
  /// asks meanwhile.
  void set_whole(mesh::MeshFacts whole) {
    facts_ = std::move(whole);
    is_whole_ = true;
  }
  bool is_whole() const { return is_whole_; }
  /// The cells or their vertices changed; nobody asks meanwhile.
  void forget() {
    facts_.reset();
    is_whole_ = false;
  }

private:
  mutable std::mutex mutex_;
  mutable std::optional<mesh::MeshFacts> facts_;
  bool is_whole_ = false;
};

} // namespace insitu::query
