#pragma once

#include <optional>
#include <string>

#include "accel/locator.h"

namespace insitu::query {

/// What the caller or the scene asks for; empty: automatic.
struct LocatorChoice {
  std::optional<accel::Method> method;
  std::optional<accel::Backend> backend;
  bool operator==(const LocatorChoice&) const = default;
};

/// What it comes to, and why, in words of at most 127 bytes.
struct LocatorPick {
  accel::Method method = accel::Method::bvh;
  accel::Backend backend = accel::Backend::cpu;
  std::string reason;
  /// Automatic choice could not have what it would have taken: said once, as a warning.
  std::string fallback;
};

/// on_device: the mesh's arrays lie in device memory. Throws INSITU_ERROR_UNSUPPORTED if an
/// explicit choice cannot be had here, or not together.
LocatorPick pick_locator(const LocatorChoice& choice, bool on_device);

} // namespace insitu::query
