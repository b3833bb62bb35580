#pragma once

#include <cstddef>
#include <thread>
#include <vector>

namespace sedov {

// Cuts [0, count) into one range per thread and calls task(part, begin, end) on each.
template <typename Task>
void for_ranges(int threads, std::size_t count, const Task& task) {
  const std::size_t parts = static_cast<std::size_t>(threads);
  std::vector<std::jthread> workers;
  for (std::size_t part = 1; part < parts; ++part)
    workers.emplace_back(
        [&, part] { task(part, count * part / parts, count * (part + 1) / parts); });
  task(0, 0, count / parts);
}

} // namespace sedov
