#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "cells/kernels/ray_cell.h"
#include "math/vec.h"
#include "render/camera/view_space.h"

namespace insitu::render {

/// A ray goes into the scene; its direction has unit length.
using cells::Ray;

/// How an automatic camera makes the mesh fit the image.
enum class Fit {
  sphere, ///< the sphere around the box of the mesh just fits: the mesh has the same size from
          ///< every side
  box     ///< the corners of the box just fit as they are seen, but for a margin: the mesh is as
          ///< large as can be
};

/// Returns the corners of a box; x changes first.
inline std::array<math::Vec3d, 8> box_corners(const math::Vec3d& low, const math::Vec3d& high) {
  std::array<math::Vec3d, 8> corners;
  for (std::size_t i = 0; i < 8; ++i)
    corners[i] = {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
  return corners;
}

/// The place from which a frame is seen.
struct Camera {
  math::Vec3d position{0, 0, 1};
  math::Vec3d look_at{0, 0, 0};
  math::Vec3d up{0, 1, 0}; ///< of any length, not along the view
  double fov = 30;         ///< vertical field of view in degrees, for perspective only
  /// Height of the view volume in mesh units. A height above 0 makes the camera orthographic.
  double orthographic_height = 0;

  /// Returns a camera that looks at the middle of a box from `azimuth` degrees around +z, counted
  /// from +x, and `elevation` degrees above the xy plane. It stands so far away that, at zoom 1,
  /// the sphere around the box just fits an image of that aspect (width / height). Up is +z. For a
  /// view from straight above or below, up points away from a viewer who came up (or down) at that
  /// azimuth.
  static Camera around(const math::Vec3d& low, const math::Vec3d& high, double azimuth,
                       double elevation, double zoom = 1, double fov = 30, double aspect = 1);

  /// Returns the camera moved, but not turned, so that the points fit an image of that aspect and
  /// their picture is centred. An orthographic camera also gets the height, and stays as far away
  /// as it is. Zoom divides the distance, or the height. margin: the part of the half of the image
  /// that stays free at its border. Points without extent (one point, or a line seen end on) are
  /// seen from near.
  Camera fitted(std::span<const math::Vec3d> points, double aspect, double zoom = 1,
                double margin = default_margin) const;
  /// Returns the camera fitted to the corners of a box.
  Camera fitted(const math::Vec3d& low, const math::Vec3d& high, double aspect, double zoom = 1,
                double margin = default_margin) const {
    return fitted(box_corners(low, high), aspect, zoom, margin);
  }

  /// Returns the height of the view of an orthographic camera, from where it stands, by which
  /// points fit; with Fit::sphere the sphere around their box fits.
  double height_for(std::span<const math::Vec3d> points, Fit fit, double aspect,
                    double margin = default_margin) const;
  double height_for(const math::Vec3d& low, const math::Vec3d& high, Fit fit, double aspect,
                    double margin = default_margin) const {
    return height_for(box_corners(low, high), fit, aspect, margin);
  }
  static constexpr double default_margin = 0.02;

  /// Returns the camera itself, or, where its up points along the view, the camera with another up:
  /// the axis farthest from the view.
  Camera with_valid_up() const;

  /// Returns the camera turned by `degrees` around the axis through look_at along up.
  Camera orbited(double degrees) const;
};

/// A place in a pixel: so far to the right of its centre and below it, in pixels.
using PixelOffset = std::array<double, 2>;

/// Returns the places of so many samples in each pixel, the first of which is the centre. The
/// samples are a lattice of rank 1, which puts one sample in each of `count` columns and rows of
/// the pixel, with the generator that keeps them farthest apart. Odd counts are even about the
/// centre.
std::vector<PixelOffset> pixel_samples(int count);

/// The axes of an image in space, which have unit length and are at right angles. Throws
/// core::Error (INSITU_ERROR_ARGUMENT) if the camera has no direction.
struct CameraAxes {
  math::Vec3d right, down, forward;
  explicit CameraAxes(const Camera& camera);
};

/// Makes the rays through the centres of the pixels of an image, or through places beside the
/// centres, see shifted(); pixel (0, 0) is the upper left one.
class RayGenerator {
public:
  /// Throws core::Error (INSITU_ERROR_ARGUMENT) if the camera has no direction or no extent.
  RayGenerator(const Camera& camera, int width, int height);
  Ray operator()(int x, int y) const;

  /// Returns a generator whose rays go through places that lie `offset` pixels to the right of the
  /// centres and below them. The image of the result is that of this one, moved to the left and up:
  /// project() tells places in the moved image.
  RayGenerator shifted(const PixelOffset& offset) const;

  /// Returns where a point is seen: x and y in pixels, where (0, 0) is the upper left corner of the
  /// image. The optional is empty for a point that is not before the camera.
  std::optional<std::array<double, 2>> project(const math::Vec3d& point) const;
  /// Returns the frame of reference in which these rays are places of an image.
  ViewSpace view() const;

private:
  CameraAxes axes_;
  math::Vec3d origin_;
  math::Vec3d corner_; ///< vector from the axis to the centre of pixel (0, 0)
  double pixel_;       ///< extent of a pixel at distance 1 (orthographic: in mesh units)
  double middle_[2];   ///< middle of the image in pixels
  bool orthographic_;
};

} // namespace insitu::render
