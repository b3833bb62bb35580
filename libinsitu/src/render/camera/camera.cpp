#include "render/camera/camera.h"

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

namespace {

using Points = std::span<const Vec3d>;

/// What of points is seen along the axes of an image, from their middle.
struct Seen {
  std::vector<double> right, down, forward;
  Seen(Points points, const Vec3d& from, const CameraAxes& axes) {
    for (const Vec3d& p : points) {
      right.push_back(dot(p - from, axes.right));
      down.push_back(dot(p - from, axes.down));
      forward.push_back(dot(p - from, axes.forward));
    }
  }
};

/// How far before the origin the tip of a wedge of half-slope `slope` must lie to hold points at
/// `across` and `forward`.
double distance_of(const std::vector<double>& across, const std::vector<double>& forward,
                   double slope) {
  double plus = -HUGE_VAL, minus = -HUGE_VAL;
  for (std::size_t i = 0; i < across.size(); ++i) {
    plus = std::max(plus, across[i] - slope * forward[i]);
    minus = std::max(minus, -across[i] - slope * forward[i]);
  }
  return 0.5 * (plus + minus) / slope;
}

/// How far aside the tip at that distance must be moved for both margins of the picture to be
/// equal. Their difference falls with the move, so halving finds it.
double aside_of(const std::vector<double>& across, const std::vector<double>& forward,
                double distance) {
  const auto difference = [&](double aside) {
    double plus = -HUGE_VAL, minus = -HUGE_VAL;
    for (std::size_t i = 0; i < across.size(); ++i) {
      const double at = (across[i] - aside) / (forward[i] + distance);
      plus = std::max(plus, at);
      minus = std::max(minus, -at);
    }
    return plus - minus;
  };
  double low = *std::min_element(across.begin(), across.end()),
         high = *std::max_element(across.begin(), across.end());
  for (int halvings = 0; halvings < 60; ++halvings) {
    const double middle = 0.5 * (low + high);
    (difference(middle) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Extent {
  double low = HUGE_VAL, high = -HUGE_VAL;
  explicit Extent(const std::vector<double>& values) {
    for (const double v : values) {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  double middle() const { return 0.5 * (low + high); }
};

/// The box around points.
struct Bounds {
  Vec3d low, high;
  explicit Bounds(Points points) : low(points[0]), high(points[0]) {
    for (const Vec3d& p : points)
      for (int a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], p[a]);
        high[a] = std::max(high[a], p[a]);
      }
  }
  Vec3d middle() const { return 0.5 * (low + high); }
  double diagonal() const { return length(high - low); }
};

} // namespace

Camera Camera::fitted(Points points, double aspect, double zoom, double margin) const {
  Camera camera = *this;
  const Bounds bounds(points);
  double distance = length(look_at - position);
  camera.look_at = bounds.middle();
  const CameraAxes axes(*this);
  const Seen seen(points, camera.look_at, axes);
  if (orthographic_height > 0) {
    camera.look_at +=
        Extent(seen.right).middle() * axes.right + Extent(seen.down).middle() * axes.down;
    camera.position = camera.look_at - distance * axes.forward; // not turned
    camera.orthographic_height = camera.height_for(points, Fit::box, aspect, margin) / zoom;
  } else if (bounds.diagonal() > 0.0) {
    const double slope = (1.0 - margin) * std::tan(0.5 * fov * degree);
    const double nearest = -Extent(seen.forward).low + 1e-3 * bounds.diagonal();
    distance = std::max({distance_of(seen.right, seen.forward, slope * aspect),
                         distance_of(seen.down, seen.forward, slope), nearest});
    camera.look_at += aside_of(seen.right, seen.forward, distance) * axes.right +
                      aside_of(seen.down, seen.forward, distance) * axes.down;
    distance /= zoom;
  }
  camera.position = camera.look_at - distance * axes.forward;
  return camera;
}

double Camera::height_for(Points points, Fit fit, double aspect, double margin) const {
  const CameraAxes axes(*this);
  double across = 0, along = 0; // halves
  if (fit == Fit::box) {
    const Seen seen(points, look_at, axes);
    const Extent right(seen.right), down(seen.down);
    across = std::max(-right.low, right.high) / (1.0 - margin);
    along = std::max(-down.low, down.high) / (1.0 - margin);
  } else {
    const Bounds bounds(points);
    const Vec3d middle = bounds.middle() - look_at;
    const double radius = 0.5 * bounds.diagonal();
    across = std::fabs(dot(middle, axes.right)) + radius;
    along = std::fabs(dot(middle, axes.down)) + radius;
  }
  const double height = 2.0 * std::max(along, across / aspect);
  return height > 0.0 ? height : 1.0; // a single point: any height shows it
}

Camera Camera::with_valid_up() const {
  const Vec3d view = look_at - position;
  if (length(cross(view, up)) > 1e-6 * length(view) * length(up))
    return *this;
  Camera camera = *this;
  double least = HUGE_VAL;
  for (int axis = 2; axis >= 0; --axis)
    if (std::fabs(view[axis]) < least) {
      least = std::fabs(view[axis]);
      camera.up = {0, 0, 0};
      camera.up[axis] = 1;
    }
  return camera;
}

CameraAxes::CameraAxes(const Camera& camera) {
  const Vec3d view = camera.look_at - camera.position;
  const Vec3d across = cross(view, camera.up);
  const double distance = length(view), side = length(across);
  if (!(distance > 0.0) || !std::isfinite(distance))
    throw core::Error(INSITU_ERROR_ARGUMENT, "camera: position and look_at are the same point");
  if (!(side > 1e-9 * distance * length(camera.up)))
    throw core::Error(INSITU_ERROR_ARGUMENT, "camera: up points along the view");
  forward = view / distance;
  right = across / side;
  down = cross(forward, right);
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
    : axes_(camera), origin_(camera.position), middle_{0.5 * width, 0.5 * height},
      orthographic_(camera.orthographic_height > 0) {
  if (!orthographic_ && !(camera.fov > 0.0 && camera.fov < 180.0))
    throw core::Error(INSITU_ERROR_ARGUMENT, "camera: a field of view between 0 and 180 degrees "
                                             "expected, " +
                                                 std::to_string(camera.fov) + " given");
  if (width < 1 || height < 1)
    throw core::Error(INSITU_ERROR_ARGUMENT, "frame: a size of at least 1 x 1 expected, " +
                                                 std::to_string(width) + " x " +
                                                 std::to_string(height) + " given");
  const double half =
      orthographic_ ? 0.5 * camera.orthographic_height : std::tan(0.5 * camera.fov * degree);
  pixel_ = 2.0 * half / height;
  corner_ =
      ((0.5 - 0.5 * width) * pixel_) * axes_.right + ((0.5 - 0.5 * height) * pixel_) * axes_.down;
}

Ray RayGenerator::operator()(int x, int y) const {
  const Vec3d offset = corner_ + (x * pixel_) * axes_.right + (y * pixel_) * axes_.down;
  if (orthographic_)
    return {origin_ + offset, axes_.forward};
  const Vec3d d = axes_.forward + offset;
  return {origin_, d / length(d)};
}

RayGenerator RayGenerator::shifted(const PixelOffset& offset) const {
  RayGenerator to = *this;
  to.corner_ += (offset[0] * pixel_) * axes_.right + (offset[1] * pixel_) * axes_.down;
  to.middle_[0] -= offset[0];
  to.middle_[1] -= offset[1];
  return to;
}

std::optional<std::array<double, 2>> RayGenerator::project(const Vec3d& point) const {
  const Vec3d from = point - origin_;
  const double depth = dot(from, axes_.forward);
  if (!(depth > 0.0))
    return std::nullopt;
  const double scale = 1.0 / (orthographic_ ? pixel_ : pixel_ * depth);
  return std::array<double, 2>{middle_[0] + scale * dot(from, axes_.right),
                               middle_[1] + scale * dot(from, axes_.down)};
}

ViewSpace RayGenerator::view() const {
  return {origin_, axes_.right / pixel_,     axes_.down / pixel_, axes_.forward,
          pixel_,  {middle_[0], middle_[1]}, orthographic_};
}

} // namespace insitu::render
