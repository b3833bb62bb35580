#include "core/log.h"

#include <cstdio>

namespace insitu::core {

void Log::warning(const std::string& m) const {
  if (warnings_.size() < most_kept)
    warnings_.push_back(m);
  write(INSITU_LOG_WARNING, m);
}

void Log::write(insitu_log_level level, const std::string& message) const {
  if (!wants(level))
    return;
  if (function_)
    function_(level, message.c_str(), user_);
  else if (level <= INSITU_LOG_WARNING)
    std::fprintf(stderr, "insitu: %s%s\n",
                 level == INSITU_LOG_ERROR ? "error: " : "warning: ", message.c_str());
}

} // namespace insitu::core
