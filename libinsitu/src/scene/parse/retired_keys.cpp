#include "scene/parse/retired_keys.h"

namespace insitu::scene {

std::span<const RetiredKey> retired_keys() {
  return {}; // none since 0.1
}

} // namespace insitu::scene
