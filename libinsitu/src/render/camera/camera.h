#pragma once

#include <array>
#include <optional>
#include <span>

#include "cells/kernels/ray_cell.h"
#include "math/vec.h"

namespace insitu::render {

/// Into the scene; its direction has unit length.
using cells::Ray;

/// How an automatic camera makes the mesh fit the image.
enum class Fit {
  sphere, ///< the sphere around the mesh's box just fits: the same size from every side
  box     ///< the box's corners as seen just fit, but for a margin: as large as can be
};

/// x changes first.
inline std::array<math::Vec3d, 8> box_corners(const math::Vec3d& low, const math::Vec3d& high) {
  std::array<math::Vec3d, 8> corners;
  for (std::size_t i = 0; i < 8; ++i)
    corners[i] = {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
  return corners;
}

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

  /// The camera moved, without being turned, so that points fit an image of that aspect and their
  /// picture is centred; an orthographic camera gets the height too, and stays as far away as it
  /// is. Zoom divides the distance, or the height. margin: the part of the image's half that stays
  /// free at its border. What has no extent (a point, a line seen end on) is seen from near.
  Camera fitted(std::span<const math::Vec3d> points, double aspect, double zoom = 1,
                double margin = default_margin) const;
  /// Of a box.
  Camera fitted(const math::Vec3d& low, const math::Vec3d& high, double aspect, double zoom = 1,
                double margin = default_margin) const {
    return fitted(box_corners(low, high), aspect, zoom, margin);
  }

  /// The height of an orthographic camera's view, from where it stands, by which points fit; with
  /// Fit::sphere the sphere around their box.
  double height_for(std::span<const math::Vec3d> points, Fit fit, double aspect,
                    double margin = default_margin) const;
  double height_for(const math::Vec3d& low, const math::Vec3d& high, Fit fit, double aspect,
                    double margin = default_margin) const {
    return height_for(box_corners(low, high), fit, aspect, margin);
  }
  static constexpr double default_margin = 0.02;

  /// The camera with another up where its own points along the view: the axis farthest from it.
  Camera with_valid_up() const;

  /// The camera turned by `degrees` around the axis through look_at along up.
  Camera orbited(double degrees) const;
};

/// The axes of an image in space, of unit length and at right angles. Throws core::Error
/// (INSITU_ERROR_ARGUMENT) if the camera has no direction.
struct CameraAxes {
  math::Vec3d right, down, forward;
  explicit CameraAxes(const Camera& camera);
};

/// The rays of an image's pixels, through their centres; pixel (0, 0) is the upper left one.
class RayGenerator {
public:
  /// Throws core::Error (INSITU_ERROR_ARGUMENT) if the camera has no direction or no extent.
  RayGenerator(const Camera& camera, int width, int height);
  Ray operator()(int x, int y) const;

  /// Where a point is seen: x and y in pixels, (0, 0) the image's upper left corner; nothing for a
  /// point that is not before the camera.
  std::optional<std::array<double, 2>> project(const math::Vec3d& point) const;

private:
  CameraAxes axes_;
  math::Vec3d origin_;
  math::Vec3d corner_; ///< from the axis to the centre of pixel (0, 0)
  double pixel_;       ///< its extent, at distance 1 (orthographic: in mesh units)
  double middle_[2];   ///< of the image, in pixels
  bool orthographic_;
};

} // namespace insitu::render
