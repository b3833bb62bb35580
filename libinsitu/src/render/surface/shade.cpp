#include "render/surface/shade.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/random.h"

namespace insitu::render {

namespace {

using math::Vec3d;

constexpr int dome_samples = 16; // of shadows under a dome, where ambient occlusion does not say

/// The digits of i in base 2, mirrored at the point: with i / n a set that covers the square evenly
/// (Hammersley 1960).
double radical_inverse(std::uint32_t i) {
  i = (i << 16) | (i >> 16);
  i = ((i & 0x00ff00ffu) << 8) | ((i & 0xff00ff00u) >> 8);
  i = ((i & 0x0f0f0f0fu) << 4) | ((i & 0xf0f0f0f0u) >> 4);
  i = ((i & 0x33333333u) << 2) | ((i & 0xccccccccu) >> 2);
  i = ((i & 0x55555555u) << 1) | ((i & 0xaaaaaaaau) >> 1);
  return i * 0x1p-32;
}

/// Two directions across n (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
void across(const Vec3d& n, Vec3d& u, Vec3d& v) {
  const double sign = std::copysign(1.0, n.z);
  const double a = -1.0 / (sign + n.z), b = n.x * n.y * a;
  u = {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  v = {b, sign + n.y * n.y * a, -n.y};
}

Vec3d unit(const Vec3d& v) {
  return v / std::sqrt(dot(v, v));
}

} // namespace

Shader::Shader(const Lighting& lighting, double occlusion_distance) : lighting_(lighting) {
  if (lighting_.lights.empty())
    lighting_.lights.push_back({});
  for (Light& light : lighting_.lights)
    if (light.kind == Light::Kind::directional)
      light.vector = unit(light.vector);
  if (!(lighting_.occlusion_distance > 0))
    lighting_.occlusion_distance = occlusion_distance;
}

/// take(direction) for rays of the half space above, as dense as the cosine.
template <class Take>
void Shader::dome(const SurfacePoint& at, int samples, int stream, Take&& take) const {
  Vec3d u, v;
  across(at.normal, u, v);
  // The same even set everywhere, shifted at random.
  const double shift[2] = {core::random_unit(at.seed, std::uint64_t(stream), 0),
                           core::random_unit(at.seed, std::uint64_t(stream), 1)};
  for (int s = 0; s < samples; ++s) {
    double a = (s + 0.5) / samples + shift[0], b = radical_inverse(std::uint32_t(s)) + shift[1];
    a -= std::floor(a);
    b -= std::floor(b);
    // On the unit disc, lifted to the sphere: density by the cosine (Malley).
    const double r = std::sqrt(a), angle = 2 * std::numbers::pi * b;
    const Vec3d d = (r * std::cos(angle)) * u + (r * std::sin(angle)) * v +
                    std::sqrt(std::fmax(0.0, 1 - a)) * at.normal;
    take(unit(d));
  }
}

template <class Sky, class Beam>
Color Shader::light(const SurfacePoint& at, Sky&& sky, Beam&& beam) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double ambient = lighting_.ambient;
  if (lighting_.occlusion_samples > 0)
    ambient *= sky(lighting_.occlusion_samples, lighting_.occlusion_distance, 0);
  Color sum{float(ambient), float(ambient), float(ambient)};
  int stream = 0;
  for (const Light& light : lighting_.lights) {
    ++stream;
    double share = lighting_.diffuse;
    if (light.kind == Light::Kind::dome) {
      if (lighting_.shadows)
        share *= sky(lighting_.occlusion_samples > 0 ? lighting_.occlusion_samples : dome_samples,
                     infinity, stream);
    } else if (light.kind == Light::Kind::head) {
      share *= std::fmax(0.0, dot(at.normal, at.to_viewer)); // what is seen is lit
    } else {
      const bool is_point = light.kind == Light::Kind::point;
      const Vec3d towards = is_point ? light.vector - at.position : light.vector;
      const double square = dot(towards, towards), distance = std::sqrt(square);
      const double cosine = dot(at.normal, towards) / distance;
      if (!(cosine > 0))
        continue;
      share *= is_point ? cosine / square : cosine;
      if (lighting_.shadows) {
        if (is_point) {
          const Vec3d rest = light.vector - at.start();
          const double length = std::sqrt(dot(rest, rest));
          share *= length > 0 ? beam(rest / length, length, stream) : 1.0;
        } else {
          share *= beam(towards, infinity, stream);
        }
      }
    }
    sum = sum + float(share) * light.color;
  }
  return sum;
}

bool Shader::asks_place() const {
  return sends_rays() ||
         std::any_of(lighting_.lights.begin(), lighting_.lights.end(),
                     [](const Light& light) { return light.kind == Light::Kind::point; });
}

std::size_t Shader::most_rays() const {
  const int sky = lighting_.occlusion_samples > 0 ? lighting_.occlusion_samples : dome_samples;
  std::size_t rays = std::size_t(lighting_.occlusion_samples);
  if (lighting_.shadows)
    for (const Light& light : lighting_.lights)
      rays += light.kind == Light::Kind::dome ? std::size_t(sky) : 1;
  return rays;
}

void Shader::send(const SurfacePoint& at, const Send& take, SurfaceCounts& counts) const {
  light(
      at,
      [&](int samples, double distance, int stream) {
        (stream == 0 ? counts.occlusion_rays : counts.shadow_rays) += samples;
        dome(at, samples, stream, [&](const Vec3d& d) { take(stream, d, distance); });
        return 1.0;
      },
      [&](const Vec3d& direction, double t_max, int stream) {
        ++counts.shadow_rays;
        take(stream, direction, t_max);
        return 1.0;
      });
}

Color Shader::factor(const SurfacePoint& at,
                     const core::FunctionRef<double(int stream)>& next) const {
  return light(
      at,
      [&](int samples, double, int stream) {
        double sum = 0;
        for (int s = 0; s < samples; ++s)
          sum += next(stream);
        return sum / samples;
      },
      [&](const Vec3d&, double, int stream) { return next(stream); });
}

Color Shader::operator()(const SurfacePoint& at, const Open& open, SurfaceCounts& counts) const {
  return light(
      at,
      [&](int samples, double distance, int stream) {
        (stream == 0 ? counts.occlusion_rays : counts.shadow_rays) += samples;
        double sum = 0;
        dome(at, samples, stream, [&](const Vec3d& d) { sum += open({at.start(), d}, distance); });
        return sum / samples;
      },
      [&](const Vec3d& direction, double t_max, int) {
        ++counts.shadow_rays;
        return open({at.start(), direction}, t_max);
      });
}

} // namespace insitu::render
