#include "free_memory.h"

#include <algorithm>
#include <fstream>
#include <string>

namespace insitu::bench {

namespace {

/// The file's first number; -1 where there is none ("max").
std::int64_t number_in(const char* path) {
  std::int64_t n = -1;
  std::ifstream(path) >> n;
  return n > 0 ? n : -1;
}

} // namespace

std::int64_t free_memory() {
  std::int64_t bytes = 0, number;
  std::ifstream info("/proc/meminfo");
  for (std::string key, unit; info >> key >> number; std::getline(info, unit))
    if (key == "MemAvailable:")
      bytes = 1024 * number;
  const std::int64_t most = number_in("/sys/fs/cgroup/memory.max"),
                     taken = number_in("/sys/fs/cgroup/memory.current");
  if (most > 0 && taken > 0)
    bytes = std::min(bytes, std::max<std::int64_t>(0, most - taken));
  return bytes;
}

} // namespace insitu::bench
