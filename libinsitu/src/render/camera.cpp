#include "render/camera.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"

namespace insitu::render {

namespace {

using math::Vec3d;

constexpr double degree = 3.14159265358979323846 / 180.0;

double length(const Vec3d& v) {
  return std::sqrt(dot(v, v));
}

} // namespace

Camera Camera::around(const Vec3d& low, const Vec3d& high, double azimuth, double elevation,
                      double zoom, double fov, double aspect) {
  Camera camera;
  camera.look_at = 0.5 * (low + high);
  camera.fov = fov;
  double radius = 0.5 * length(high - low);
  if (!(radius > 0.0))
    radius = 0.5; // a single point: any distance shows it
  const double half_vertical = 0.5 * fov * degree;
  const double half_horizontal = std::atan(aspect * std::tan(half_vertical));
  const double distance = radius / std::sin(std::min(half_vertical, half_horizontal)) / zoom;
  // Exact at right angles, where up must not be off the axis.
  const double across = std::fabs(elevation) == 90.0 ? 0.0 : std::cos(elevation * degree);
  const Vec3d towards{across * std::cos(azimuth * degree), across * std::sin(azimuth * degree),
                      std::sin(elevation * degree)};
  camera.position = camera.look_at + distance * towards;
  camera.up =
      across == 0.0
          ? Vec3d{elevation > 0 ? -std::cos(azimuth * degree) : std::cos(azimuth * degree),
                  elevation > 0 ? -std::sin(azimuth * degree) : std::sin(azimuth * degree), 0}
          : Vec3d{0, 0, 1};
  return camera;
}

Camera Camera::orbited(double degrees) const {
  Camera turned = *this;
  const double size = length(up);
  if (size == 0.0)
    return turned;
  const Vec3d axis = up / size, arm = position - look_at;
  const double c = std::cos(degrees * degree), s = std::sin(degrees * degree);
  // Rodrigues' rotation.
  turned.position = look_at + c * arm + s * cross(axis, arm) + ((1 - c) * dot(axis, arm)) * axis;
  return turned;
}

RayGenerator::RayGenerator(const Camera& camera, int width, int height)
    : origin_(camera.position), orthographic_(camera.orthographic_height > 0) {
  const Vec3d view = camera.look_at - camera.position;
  const Vec3d across = cross(view, camera.up);
  const double distance = length(view), side = length(across);
  if (!(distance > 0.0) || !std::isfinite(distance))
    throw core::Error(INSITU_ERROR_ARGUMENT, "camera: position and look_at are the same point");
  if (!(side > 1e-9 * distance * length(camera.up)))
    throw core::Error(INSITU_ERROR_ARGUMENT, "camera: up points along the view");
  if (!orthographic_ && !(camera.fov > 0.0 && camera.fov < 180.0))
    throw core::Error(INSITU_ERROR_ARGUMENT, "camera: a field of view between 0 and 180 degrees "
                                             "expected, " +
                                                 std::to_string(camera.fov) + " given");
  if (width < 1 || height < 1)
    throw core::Error(INSITU_ERROR_ARGUMENT, "frame: a size of at least 1 x 1 expected, " +
                                                 std::to_string(width) + " x " +
                                                 std::to_string(height) + " given");
  forward_ = view / distance;
  right_ = across / side;
  down_ = cross(forward_, right_);
  const double half =
      orthographic_ ? 0.5 * camera.orthographic_height : std::tan(0.5 * camera.fov * degree);
  pixel_ = 2.0 * half / height;
  corner_ = ((0.5 - 0.5 * width) * pixel_) * right_ + ((0.5 - 0.5 * height) * pixel_) * down_;
}

Ray RayGenerator::operator()(int x, int y) const {
  const Vec3d offset = corner_ + (x * pixel_) * right_ + (y * pixel_) * down_;
  if (orthographic_)
    return {origin_ + offset, forward_};
  const Vec3d d = forward_ + offset;
  return {origin_, d / length(d)};
}

} // namespace insitu::render
