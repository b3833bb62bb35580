#include "render/camera/camera_path.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"

namespace insitu::render {

namespace {

using math::Vec3d;

constexpr double degree = 3.14159265358979323846 / 180.0;

double size_of(double v) {
  return std::fabs(v);
}
double size_of(const Vec3d& v) {
  return std::sqrt(dot(v, v));
}

template <class T>
T shortened(const T& slope, double most) {
  const double size = size_of(slope);
  return size > most ? (most / size) * slope : slope;
}

/// The slope at key i; mean(i) is the mean slope between keys i and i + 1.
template <class Mean>
auto slope_at(std::span<const double> at, std::size_t i, const Mean& mean) {
  const std::size_t last = at.size() - 1;
  const auto inner = [&](std::size_t k) {
    const auto before = mean(k - 1), after = mean(k);
    const double left = at[k] - at[k - 1], right = at[k + 1] - at[k];
    return shortened((right / (left + right)) * before + (left / (left + right)) * after,
                     2.0 * std::min(size_of(before), size_of(after)));
  };
  if (i > 0 && i < last)
    return inner(i);
  const auto end = mean(i == 0 ? 0 : last - 1);
  if (last == 1)
    return end;
  // The segment at an end is a parabola.
  return shortened(1.5 * end - 0.5 * inner(i == 0 ? 1 : last - 1), 2.0 * size_of(end));
}

std::size_t segment_of(std::span<const double> at, double place) {
  const auto above = std::upper_bound(at.begin(), at.end(), place);
  return std::size_t(above - at.begin()) - 1;
}

template <class T>
T smooth_value(std::span<const double> at, std::span<const T> values, double place) {
  if (!(place > at.front()))
    return values.front();
  if (place >= at.back())
    return values.back();
  const std::size_t i = segment_of(at, place);
  const double width = at[i + 1] - at[i], u = (place - at[i]) / width;
  const auto mean = [&](std::size_t k) {
    return (1.0 / (at[k + 1] - at[k])) * (values[k + 1] - values[k]);
  };
  // From the nearer key, so that equal keys give their value exactly.
  const double rise = u * u * (3.0 - 2.0 * u);
  return values[i] + rise * (values[i + 1] - values[i]) +
         (width * u * (1.0 - u) * (1.0 - u)) * slope_at(at, i, mean) -
         (width * u * u * (1.0 - u)) * slope_at(at, i + 1, mean);
}

[[noreturn]] void refuse(const std::string& message) {
  throw core::Error(INSITU_ERROR_ARGUMENT, "camera path: " + message);
}

} // namespace

double smooth(std::span<const double> at, std::span<const double> values, double place) {
  return smooth_value(at, values, place);
}
Vec3d smooth(std::span<const double> at, std::span<const Vec3d> values, double place) {
  return smooth_value(at, values, place);
}

CameraPath::CameraPath(std::vector<CameraKey> keys) : keys_(std::move(keys)) {
  if (keys_.empty())
    refuse("no key; at least one expected");
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const CameraKey& key = keys_[i];
    const Camera& camera = key.camera;
    if (!std::isfinite(key.at) || (i > 0 && !(key.at > keys_[i - 1].at)))
      refuse("key " + std::to_string(i) + " at " + std::to_string(key.at) +
             " does not lie after the one before it");
    const bool orthographic = camera.orthographic_height > 0;
    if (orthographic != (keys_[0].camera.orthographic_height > 0))
      refuse("key " + std::to_string(i) + " is " + (orthographic ? "" : "not ") +
             "orthographic, unlike the first");
    const Camera valid = camera.with_valid_up();
    const CameraAxes axes(valid);
    at_.push_back(key.at);
    positions_.push_back(camera.position);
    ups_.push_back(valid.up / size_of(valid.up));
    distances_.push_back(std::log(size_of(camera.look_at - camera.position)));
    openings_.push_back(
        std::log(orthographic ? camera.orthographic_height : std::tan(0.5 * camera.fov * degree)));
    fixed_aim_ = fixed_aim_ && camera.look_at == keys_[0].camera.look_at;
    orientations_.push_back(of(axes));
    if (i > 0) {
      // q and -q are one orientation: the nearer of them is the shorter way.
      Quaternion& q = orientations_[i];
      const Quaternion& before = orientations_[i - 1];
      if (q.w * before.w + dot(q.v, before.v) < 0)
        q = {-q.w, -q.v};
      turns_.push_back(turn(before, q));
    }
  }
}

Camera CameraPath::at(double place) const {
  if (!(place > at_.front()))
    return keys_.front().camera.with_valid_up();
  if (place >= at_.back())
    return keys_.back().camera.with_valid_up();
  const std::size_t segment = segment_of(at_, place);
  if (at_[segment] == place)
    return keys_[segment].camera.with_valid_up();
  Camera camera = keys_[segment].camera;
  camera.position = smooth(at_, positions_, place);
  const double opening = std::exp(smooth(at_, openings_, place));
  if (camera.orthographic_height > 0)
    camera.orthographic_height = opening;
  else
    camera.fov = 2.0 * std::atan(opening) / degree;
  if (fixed_aim_)
    camera.up = smooth(at_, ups_, place);
  else
    orient(camera, segment, place);
  return camera.with_valid_up();
}

void CameraPath::orient(Camera& camera, std::size_t segment, double place) const {
  const double width = at_[segment + 1] - at_[segment], u = (place - at_[segment]) / width;
  // A turn between two orientations has the same axis in the frame of either, so that the slopes
  // on both sides of a key can be added.
  const auto mean = [&](std::size_t k) { return (1.0 / (at_[k + 1] - at_[k])) * turns_[k]; };
  const Quaternion &first = orientations_[segment], &last = orientations_[segment + 1];
  const Quaternion q[4] = {first, turned(first, (width / 3.0) * slope_at(at_, segment, mean)),
                           turned(last, (-width / 3.0) * slope_at(at_, segment + 1, mean)), last};
  const auto slerp = [&](const Quaternion& a, const Quaternion& b) {
    return turned(a, u * turn(a, b));
  };
  const Quaternion a = slerp(q[0], q[1]), b = slerp(q[1], q[2]), c = slerp(q[2], q[3]);
  const Quaternion now = slerp(slerp(a, b), slerp(b, c));
  const auto rotated = [&](const Vec3d& p) {
    const Vec3d t = 2.0 * cross(now.v, p);
    return p + now.w * t + cross(now.v, t);
  };
  camera.up = rotated({0, -1, 0});
  camera.look_at = camera.position + std::exp(smooth(at_, distances_, place)) * rotated({0, 0, 1});
}

CameraPath::Quaternion CameraPath::product(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - dot(a.v, b.v), a.w * b.v + b.w * a.v + cross(a.v, b.v)};
}

/// The logarithm of from^-1 to.
Vec3d CameraPath::turn(const Quaternion& from, const Quaternion& to) {
  const Quaternion q = product({from.w, -from.v}, to);
  const double sine = size_of(q.v);
  return sine > 0.0 ? (std::atan2(sine, q.w) / sine) * q.v : Vec3d{0, 0, 0};
}

CameraPath::Quaternion CameraPath::turned(const Quaternion& from, const Vec3d& turn) {
  const double angle = size_of(turn);
  const double scale = angle > 0.0 ? std::sin(angle) / angle : 1.0;
  return product(from, {std::cos(angle), scale * turn});
}

/// The rotation that takes x, y, z to right, down, forward: by the largest of its four numbers, so
/// that no division is by little.
CameraPath::Quaternion CameraPath::of(const CameraAxes& axes) {
  const Vec3d &x = axes.right, &y = axes.down, &z = axes.forward;
  const double squares[4] = {1 + x.x + y.y + z.z, 1 + x.x - y.y - z.z, 1 - x.x + y.y - z.z,
                             1 - x.x - y.y + z.z};
  const auto largest = std::max_element(squares, squares + 4) - squares;
  const double s = std::sqrt(squares[largest]), h = 0.5 / s;
  switch (largest) {
  case 0:
    return {0.5 * s, {h * (y.z - z.y), h * (z.x - x.z), h * (x.y - y.x)}};
  case 1:
    return {h * (y.z - z.y), {0.5 * s, h * (x.y + y.x), h * (z.x + x.z)}};
  case 2:
    return {h * (z.x - x.z), {h * (x.y + y.x), 0.5 * s, h * (y.z + z.y)}};
  default:
    return {h * (x.y - y.x), {h * (z.x + x.z), h * (y.z + z.y), 0.5 * s}};
  }
}

} // namespace insitu::render
