#pragma once

namespace insitu::scene {

/// A number made of all values of a field at one step; of a vector field, of the values'
/// magnitudes. value: none of these, the field's own value at a point.
enum class Reduction { min, max, mean, value };

/// "min", "max", "mean" or "value".
inline const char* reduction_name(Reduction reduction) {
  switch (reduction) {
  case Reduction::min:
    return "min";
  case Reduction::max:
    return "max";
  case Reduction::value:
    return "value";
  default:
    return "mean";
  }
}

} // namespace insitu::scene
