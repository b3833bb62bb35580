#pragma once

#include <string>

#include "insitu/insitu.h"

namespace insitu::core {

/// The session's log. Messages go to the caller's function, or errors and warnings to stderr.
class Log {
public:
  Log() = default;
  Log(insitu_log_level level, insitu_log_function function, void* user)
      : level_(level), function_(function), user_(user) {}

  void error(const std::string& m) const { write(INSITU_LOG_ERROR, m); }
  void warning(const std::string& m) const { write(INSITU_LOG_WARNING, m); }
  void info(const std::string& m) const { write(INSITU_LOG_INFO, m); }
  void debug(const std::string& m) const { write(INSITU_LOG_DEBUG, m); }
  bool wants(insitu_log_level level) const { return level <= level_; }

private:
  void write(insitu_log_level level, const std::string& message) const;

  insitu_log_level level_ = INSITU_LOG_WARNING;
  insitu_log_function function_ = nullptr;
  void* user_ = nullptr;
};

} // namespace insitu::core
