#pragma once

#include <array>

#include "math/vec.h"

namespace insitu::accel {

/// The part of space that a rectangle of an image shows, before the eye. A point p lies in it where
/// dot(normal, p - eye) + shift >= 0 for every side; its depth is dot(forward, p - eye).
struct Frustum {
  struct Side {
    math::Vec3d normal;
    double shift = 0; ///< 0 where all rays begin at the eye
  };
  math::Vec3d eye, forward;
  std::array<Side, 4> sides;
};

} // namespace insitu::accel
