#include "core/text.h"

#include <cstdio>
#include <memory>

namespace insitu::core {

std::optional<std::string> read_file(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             std::fclose);
  if (!file)
    return std::nullopt;
  std::string text;
  char some[1 << 14];
  while (const std::size_t count = std::fread(some, 1, sizeof some, file.get()))
    text.append(some, count);
  return std::ferror(file.get()) ? std::nullopt : std::optional(std::move(text));
}

} // namespace insitu::core
