#pragma once

#include <string>

#include "insitu/insitu.h"

namespace insitu::scene {

/// The name of something that must exist when the scene runs: a field, a mesh. Empty where not
/// given.
struct Name {
  std::string text;
  int line = 0;
  bool empty() const { return text.empty(); }
};

enum class Accuracy { fast, standard, exact };

inline insitu_accuracy to_api(Accuracy accuracy) {
  switch (accuracy) {
  case Accuracy::fast:
    return INSITU_FAST;
  case Accuracy::standard:
    return INSITU_STANDARD;
  case Accuracy::exact:
    break;
  }
  return INSITU_EXACT;
}

} // namespace insitu::scene
