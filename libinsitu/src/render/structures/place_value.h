#pragma once

#include <cstdint>

namespace insitu::render {

/// A field at a place.
struct PlaceValue {
  /// That holds the place: flat, or the key of one of any process (FramePart::key); -1: none does.
  std::int64_t cell = -1;
  double value = 0;
};

} // namespace insitu::render
