#pragma once

#include <span>
#include <vector>

#include "render/camera/camera.h"

namespace insitu::render {

/// A smooth curve through values at ascending places: a cubic Hermite spline whose slope at a key
/// is that of the parabola through it and its neighbours (a Catmull-Rom spline with knots at the
/// keys' own places, so that the speed has no jump at a key), but never steeper than twice the mean
/// slope on either side. What rests between two equal keys therefore rests, and the curve hardly
/// leaves the range of its keys. With two keys: a straight line at constant speed. Before the first
/// and after the last key: their values. at and values are of one length, at least 1.
double smooth(std::span<const double> at, std::span<const double> values, double place);
math::Vec3d smooth(std::span<const double> at, std::span<const math::Vec3d> values, double place);

/// A camera at a place along its path, a cycle or a time.
struct CameraKey {
  double at = 0;
  Camera camera;
};

/// A camera that goes smoothly through keys, exact at each. Positions go along smooth(). Where all
/// keys look at one point, so does the camera between them; else its orientation is interpolated on
/// the sphere of quaternions, by cubic Bezier curves of slerps (Shoemake 1985, "Animating rotation
/// with quaternion curves") with slopes as in smooth(), always the shorter way. Distances to what
/// is looked at, openings and heights are interpolated by their logarithms.
class CameraPath {
public:
  /// Throws core::Error (INSITU_ERROR_ARGUMENT) unless there is a key, the places ascend, every
  /// camera has a direction, and all are perspective or all orthographic.
  explicit CameraPath(std::vector<CameraKey> keys);

  Camera at(double place) const;

private:
  struct Quaternion {
    double w = 1;
    math::Vec3d v;
  };
  static Quaternion product(const Quaternion& a, const Quaternion& b);
  static math::Vec3d turn(const Quaternion& from, const Quaternion& to);
  static Quaternion turned(const Quaternion& from, const math::Vec3d& turn);
  static Quaternion of(const CameraAxes& axes);
  void orient(Camera& camera, std::size_t segment, double place) const;

  std::vector<CameraKey> keys_;
  std::vector<double> at_, distances_, openings_;
  std::vector<math::Vec3d> positions_, ups_;
  std::vector<Quaternion> orientations_;
  std::vector<math::Vec3d>
      turns_; ///< from each orientation to the next, halves of rotation vectors
  bool fixed_aim_ = true;
};

} // namespace insitu::render
