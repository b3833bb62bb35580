#pragma once

#include "math/vec.h"

namespace insitu::render {

/// A ray of unit direction, so that distances along it are lengths.
struct Ray {
  math::Vec3d origin, direction;
};

/// Where a frame is seen from.
struct Camera {
  math::Vec3d position{0, 0, 1};
  math::Vec3d look_at{0, 0, 0};
  math::Vec3d up{0, 1, 0}; ///< any length, not along the view
  double fov = 30;         ///< vertical field of view, degrees; perspective only
  /// Height of the view volume in mesh units; above 0 makes the camera orthographic.
  double orthographic_height = 0;

  /// A camera towards the middle of a box from `azimuth` degrees around +z, counted from +x, and
  /// `elevation` degrees above the xy plane, so far away that the sphere around the box just fits
  /// an image of that aspect (width / height) at zoom 1. Up is +z; from above or below, away from
  /// the viewer who came up (or down) at that azimuth.
  static Camera around(const math::Vec3d& low, const math::Vec3d& high, double azimuth,
                       double elevation, double zoom = 1, double fov = 30, double aspect = 1);

  /// The camera turned by `degrees` around the axis through look_at along up.
  Camera orbited(double degrees) const;
};

/// The rays of an image's pixels, through their centres; pixel (0, 0) is the upper left one.
class RayGenerator {
public:
  /// Throws core::Error (INSITU_ERROR_ARGUMENT) if the camera has no direction or no extent.
  RayGenerator(const Camera& camera, int width, int height);
  Ray operator()(int x, int y) const;

private:
  math::Vec3d origin_, forward_, right_, down_;
  math::Vec3d corner_; ///< from the axis to the centre of pixel (0, 0)
  double pixel_;       ///< its extent, at distance 1 (orthographic: in mesh units)
  bool orthographic_;
};

} // namespace insitu::render
