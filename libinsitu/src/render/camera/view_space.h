#pragma once

#include <cmath>

#include "accel/camera_rays/frustum.h"
#include "math/vec.h"

namespace insitu::render {

/// A frame of reference at a camera: x to the right and y down in sizes of a pixel at depth 1, z
/// the depth. A perspective camera sees a point at the image place (x / z, y / z) from the image's
/// middle, in pixels; an orthographic one at (x, y).
struct ViewSpace {
  math::Vec3d origin, right, down, forward; ///< right and down are divided by a pixel's size
  double pixel = 1;                         ///< its size at depth 1
  double middle[2] = {0, 0};                ///< of the image, in pixels
  bool orthographic = false;

  math::Vec3d operator()(const math::Vec3d& p) const {
    const math::Vec3d v = p - origin;
    return {dot(v, right), dot(v, down), dot(v, forward)};
  }
  /// The image place of a pixel's centre, from the middle.
  double column(double x) const { return x + 0.5 - middle[0]; }
  double row(double y) const { return y + 0.5 - middle[1]; }
  /// How long a ray through the pixel's centre is at depth 1.
  double length_at(double x, double y) const {
    if (orthographic)
      return 1.0;
    const double c = pixel * column(x), r = pixel * row(y);
    return std::sqrt(1.0 + c * c + r * r);
  }

  /// What the pixels [x0, x1] x [y0, y1] show, their borders included, and a little more.
  accel::Frustum frustum(int x0, int y0, int x1, int y1) const {
    constexpr double border = 0.51;
    const double low[2] = {column(x0) - border, row(y0) - border};
    const double high[2] = {column(x1) + border, row(y1) + border};
    const math::Vec3d axes[2] = {right, down};
    accel::Frustum frustum;
    frustum.eye = origin;
    frustum.forward = forward;
    for (std::size_t a = 0; a < 2; ++a)
      if (orthographic) {
        frustum.sides[2 * a] = {axes[a], -low[a]};
        frustum.sides[2 * a + 1] = {-axes[a], high[a]};
      } else {
        frustum.sides[2 * a] = {axes[a] - low[a] * forward};
        frustum.sides[2 * a + 1] = {high[a] * forward - axes[a]};
      }
    return frustum;
  }
};

} // namespace insitu::render
