#pragma once

#include <cstddef>

#include "core/parallel.h"

namespace insitu::core {

/// Calls work(i) for each i in [0, n), several at once, each on one thread. Rethrows the first
/// exception.
template <class Work>
void for_each(const Threads& threads, std::size_t n, Work&& work) {
  threads.parallel_for(std::int64_t(n), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      work(std::size_t(i));
  });
}

} // namespace insitu::core
