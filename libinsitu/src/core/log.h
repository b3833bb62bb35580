#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "insitu/insitu.h"

namespace insitu::core {

/// The session's log. Messages go to the caller's function, or errors and warnings to stderr.
/// Warnings are kept too, whatever the level, until they are taken.
class Log {
public:
  Log() = default;
  Log(insitu_log_level level, insitu_log_function function, void* user)
      : level_(level), function_(function), user_(user) {}

  void error(const std::string& m) const { write(INSITU_LOG_ERROR, m); }
  void warning(const std::string& m) const;
  void info(const std::string& m) const { write(INSITU_LOG_INFO, m); }
  void debug(const std::string& m) const { write(INSITU_LOG_DEBUG, m); }
  bool wants(insitu_log_level level) const { return level <= level_; }

  static constexpr std::size_t most_kept = 32; ///< further warnings are not kept
  std::vector<std::string> take_warnings() { return std::exchange(warnings_, {}); }

private:
  void write(insitu_log_level level, const std::string& message) const;

  insitu_log_level level_ = INSITU_LOG_WARNING;
  insitu_log_function function_ = nullptr;
  void* user_ = nullptr;
  mutable std::vector<std::string> warnings_; ///< a session has one caller at a time
};

} // namespace insitu::core
