#include "scene/run/environment.h"

#include <cstdio>

namespace insitu::scene {

std::string cycle_path(const Environment& environment, const std::string& name, std::int64_t cycle,
                       const std::string& extension) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "_%06lld", static_cast<long long>(cycle));
  return environment.output + "/" + name + digits + extension;
}

} // namespace insitu::scene
