#pragma once

#include <span>

namespace insitu::scene {

/// A key of the scene that got another name. For one version the old one still works, and a warning
/// names the new one; then its line here goes, and with it the key.
struct RetiredKey {
  const char* place; ///< the map that holds it, without indices: "" (the scene), "frames.volume"
  const char* old;
  const char* now;  ///< in the same map, with the same value
  const char* gone; ///< the version that knows the old one no more, such as "0.4"
};

/// Those of this version. doc/stability.md tells users of the rule.
std::span<const RetiredKey> retired_keys();

} // namespace insitu::scene
