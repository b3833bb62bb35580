#include "scene/checkpoint/checkpoint_files.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <vector>

namespace insitu::scene {

namespace {

constexpr std::string_view file_begin = "checkpoint_", file_end = ".insitu";

} // namespace

std::string checkpoint_path(const std::string& folder, std::int64_t cycle) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%06lld", static_cast<long long>(cycle));
  return folder + "/" + std::string(file_begin) + digits + std::string(file_end);
}

void remove_old_checkpoints(const std::string& folder, std::int64_t cycle, std::int64_t keep,
                            bool descends) {
  std::vector<std::int64_t> cycles;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(file_begin) || !name.ends_with(file_end))
      continue;
    std::int64_t of = 0;
    const char* end = name.data() + name.size() - file_end.size();
    const auto parsed = std::from_chars(name.data() + file_begin.size(), end, of);
    if (parsed.ec == std::errc() && parsed.ptr == end && (descends ? of >= cycle : of <= cycle) &&
        entry.path().string() == checkpoint_path(folder, of))
      cycles.push_back(of);
  }
  std::sort(cycles.rbegin(), cycles.rend());
  if (descends)
    std::reverse(cycles.begin(), cycles.end());
  for (std::size_t i = std::size_t(keep); i < cycles.size(); ++i)
    std::filesystem::remove(checkpoint_path(folder, cycles[i]), error);
}

} // namespace insitu::scene
