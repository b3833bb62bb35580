#include "render/color/color_space.h"

#include <algorithm>
#include <cmath>

namespace insitu::render {

namespace {

using math::Vec3d;

constexpr double pi = 3.14159265358979323846;
constexpr Vec3d white{0.95047, 1.0, 1.08883}; // D65, XYZ
constexpr double kink = 6.0 / 29.0;

double lab_curve(double t) {
  return t > kink * kink * kink ? std::cbrt(t) : t / (3 * kink * kink) + 4.0 / 29.0;
}
double lab_curve_inverse(double t) {
  return t > kink ? t * t * t : 3 * kink * kink * (t - 4.0 / 29.0);
}

Color clamped(const Vec3d& linear) {
  return {float(std::clamp(linear.x, 0.0, 1.0)), float(std::clamp(linear.y, 0.0, 1.0)),
          float(std::clamp(linear.z, 0.0, 1.0))};
}

/// Hue in turns, saturation, value.
Vec3d hsv_of(const Vec3d& c) {
  const double high = std::max({c.x, c.y, c.z}), low = std::min({c.x, c.y, c.z});
  const double chroma = high - low;
  double hue = 0;
  if (chroma > 0) {
    if (high == c.x)
      hue = (c.y - c.z) / chroma;
    else if (high == c.y)
      hue = 2 + (c.z - c.x) / chroma;
    else
      hue = 4 + (c.x - c.y) / chroma;
    hue /= 6;
    hue -= std::floor(hue);
  }
  return {hue, high > 0 ? chroma / high : 0, high};
}

Vec3d rgb_of_hsv(const Vec3d& c) {
  const auto channel = [&](double offset) {
    double k = offset + 6 * c.x;
    k -= 6 * std::floor(k / 6);
    return c.z - c.z * c.y * std::max(0.0, std::min({k, 4 - k, 1.0}));
  };
  return {channel(5), channel(3), channel(1)};
}

/// Moreland's Msh: polar CIELAB.
Vec3d msh_of(const Vec3d& lab) {
  const double m = std::sqrt(dot(lab, lab));
  const double s = m > 0.001 ? std::acos(std::clamp(lab.x / m, -1.0, 1.0)) : 0;
  return {m, s, s > 0.001 ? std::atan2(lab.z, lab.y) : 0};
}
Vec3d lab_of_msh(const Vec3d& msh) {
  const double side = msh.x * std::sin(msh.y);
  return {msh.x * std::cos(msh.y), side * std::cos(msh.z), side * std::sin(msh.z)};
}

/// The hue of an unsaturated colour that makes the path towards a saturated one bend evenly.
double adjusted_hue(const Vec3d& saturated, double unsaturated_m) {
  if (saturated.x >= unsaturated_m - 0.1)
    return saturated.z;
  const double spin = saturated.y *
                      std::sqrt(unsaturated_m * unsaturated_m - saturated.x * saturated.x) /
                      (saturated.x * std::sin(saturated.y));
  return saturated.z > -pi / 3 ? saturated.z + spin : saturated.z - spin;
}

Vec3d diverging(const Vec3d& a, const Vec3d& b, double u) {
  Vec3d first = msh_of(lab_of_srgb(a)), last = msh_of(lab_of_srgb(b));
  double turn = std::fabs(first.z - last.z);
  turn = turn > pi ? 2 * pi - turn : turn;
  if (first.y > 0.05 && last.y > 0.05 && turn > pi / 3) {
    // Two saturated hues far apart: through white, or as near to it as their brightness asks.
    const double middle = std::max({first.x, last.x, 88.0});
    if (u < 0.5) {
      last = {middle, 0, 0};
      u = 2 * u;
    } else {
      first = {middle, 0, 0};
      u = 2 * u - 1;
    }
  }
  if (first.y < 0.05 && last.y > 0.05)
    first.z = adjusted_hue(last, first.x);
  else if (last.y < 0.05 && first.y > 0.05)
    last.z = adjusted_hue(first, last.x);
  return linear_of_lab(lab_of_msh((1 - u) * first + u * last));
}

} // namespace

Vec3d lab_of_srgb(const Vec3d& rgb) {
  const double r = linear_of_srgb(rgb.x), g = linear_of_srgb(rgb.y), b = linear_of_srgb(rgb.z);
  // IEC 61966-2-1's primaries.
  const double x = lab_curve((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / white.x);
  const double y = lab_curve((0.2126729 * r + 0.7151522 * g + 0.0721750 * b) / white.y);
  const double z = lab_curve((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / white.z);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Vec3d linear_of_lab(const Vec3d& lab) {
  const double fy = (lab.x + 16) / 116;
  const double x = white.x * lab_curve_inverse(fy + lab.y / 500);
  const double y = white.y * lab_curve_inverse(fy);
  const double z = white.z * lab_curve_inverse(fy - lab.z / 200);
  return {3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
          -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
          0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
}

Color mix(ColorSpace space, const Vec3d& a, const Vec3d& b, double u) {
  switch (space) {
  case ColorSpace::rgb: {
    const Vec3d c = (1 - u) * a + u * b;
    return linear_of_srgb(c.x, c.y, c.z);
  }
  case ColorSpace::hsv: {
    Vec3d first = hsv_of(a), last = hsv_of(b);
    // A grey end takes the other's hue; otherwise the short way around.
    if (first.y == 0)
      first.x = last.x;
    else if (last.y == 0)
      last.x = first.x;
    if (last.x - first.x > 0.5)
      first.x += 1;
    else if (first.x - last.x > 0.5)
      last.x += 1;
    const Vec3d c = rgb_of_hsv((1 - u) * first + u * last);
    return linear_of_srgb(c.x, c.y, c.z);
  }
  case ColorSpace::lab:
    return clamped(linear_of_lab((1 - u) * lab_of_srgb(a) + u * lab_of_srgb(b)));
  case ColorSpace::diverging:
    return clamped(diverging(a, b, u));
  case ColorSpace::linear:
    break;
  }
  const float w = float(u);
  return (1 - w) * linear_of_srgb(a.x, a.y, a.z) + w * linear_of_srgb(b.x, b.y, b.z);
}

} // namespace insitu::render
