#pragma once

#include <mutex>
#include <optix.h>
#include <string>

#include "insitu/insitu.h"

namespace insitu::accel::optix {

/// The process's OptiX device context on the current CUDA device: made at the first use, never
/// destroyed, since the driver's library is gone before static objects are.
class Context {
public:
  /// Throws INSITU_ERROR_UNSUPPORTED with why_unavailable().
  static Context& get();
  /// Empty if OptiX can be used here, else why not.
  static std::string why_unavailable();

  OptixDeviceContext handle() const { return handle_; }
  /// The most primitives that a structure of one level may have.
  std::int64_t most_primitives() const { return most_primitives_; }
  /// The driver's last message of a warning or an error, and forgets it: the reason behind a
  /// result's name.
  std::string take_message();

private:
  Context() = default;
  static void log(unsigned level, const char* tag, const char* message, void* context);

  OptixDeviceContext handle_ = nullptr;
  std::int64_t most_primitives_ = 0;
  std::string why_not_;
  std::mutex mutex_;
  std::string message_;

  static Context& instance();
  void open();
};

/// Throws core::Error that names the action, the result and the driver's message, unless OptiX
/// succeeded.
void check(OptixResult result, const std::string& action);

} // namespace insitu::accel::optix
