#pragma once

#include <string>

namespace insitu::scene {

/// The name of something that must exist when the scene runs: a field, a mesh. Empty where not
/// given.
struct Name {
  std::string text;
  int line = 0;
  bool empty() const { return text.empty(); }
};

} // namespace insitu::scene
