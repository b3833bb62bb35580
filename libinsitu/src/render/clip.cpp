#include "render/clip.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace insitu::render {

namespace {

using math::Vec3d;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The part of the line that the half-space below the plane holds, or the inside of the others.
std::optional<Stretch> behind_plane(const Clip& clip, const Ray& ray) {
  const double height = dot(clip.vector, clip.point - ray.origin);
  const double slope = dot(clip.vector, ray.direction);
  if (slope == 0)
    return height >= 0 ? std::optional(Stretch{-infinity, infinity}) : std::nullopt;
  const double t = height / slope;
  return slope > 0 ? Stretch{-infinity, t} : Stretch{t, infinity};
}

std::optional<Stretch> in_box(const Clip& clip, const Ray& ray) {
  Stretch in{-infinity, infinity};
  for (int a = 0; a < 3; ++a) {
    const double low = clip.point[a] - ray.origin[a], high = clip.vector[a] - ray.origin[a];
    const double d = ray.direction[a];
    if (d == 0) {
      if (low > 0 || high < 0)
        return std::nullopt;
      continue;
    }
    in.from = std::max(in.from, (d > 0 ? low : high) / d);
    in.to = std::min(in.to, (d > 0 ? high : low) / d);
  }
  return in.from <= in.to ? std::optional(in) : std::nullopt;
}

std::optional<Stretch> in_sphere(const Clip& clip, const Ray& ray) {
  // From the point of the ray that is nearest to the centre: the textbook's discriminant would
  // cancel for a viewer many radii away.
  const Vec3d to_centre = clip.point - ray.origin;
  const double square = dot(ray.direction, ray.direction);
  const double middle = dot(to_centre, ray.direction) / square;
  const Vec3d across = to_centre - middle * ray.direction;
  const double rest = clip.radius * clip.radius - dot(across, across);
  if (!(rest >= 0))
    return std::nullopt;
  const double half = std::sqrt(rest / square);
  return Stretch{middle - half, middle + half};
}

std::optional<Stretch> inside(const Clip& clip, const Ray& ray) {
  switch (clip.kind) {
  case Clip::Kind::plane:
    return behind_plane(clip, ray);
  case Clip::Kind::box:
    return in_box(clip, ray);
  case Clip::Kind::sphere:
    break;
  }
  return in_sphere(clip, ray);
}

} // namespace

void clip_ray(const std::vector<Clip>& clips, const Ray& ray, double near, double far,
              std::vector<Stretch>& stays) {
  stays.clear();
  if (!(near <= far))
    return;
  stays.push_back({near, far});
  for (const Clip& clip : clips) {
    const std::optional<Stretch> in = inside(clip, ray);
    const bool keep = clip.keep_inside || clip.kind == Clip::Kind::plane;
    if (!in) {
      if (keep) {
        stays.clear();
        return;
      }
      continue;
    }
    std::size_t kept = 0, parted_at = 0;
    std::optional<Stretch> parted; // the rest of the one stretch that what goes lies within
    for (std::size_t i = 0; i < stays.size(); ++i) {
      const Stretch s = stays[i];
      if (keep) {
        const Stretch rest{std::max(s.from, in->from), std::min(s.to, in->to)};
        if (rest.from < rest.to)
          stays[kept++] = rest;
        continue;
      }
      const Stretch before{s.from, std::min(s.to, in->from)}, after{std::max(s.from, in->to), s.to};
      const bool begins = before.from < before.to;
      if (begins)
        stays[kept++] = before;
      if (!(after.from < after.to))
        continue;
      if (begins) {
        parted = after;
        parted_at = kept;
      } else {
        stays[kept++] = after;
      }
    }
    stays.resize(kept);
    if (parted)
      stays.insert(stays.begin() + std::ptrdiff_t(parted_at), *parted);
  }
}

} // namespace insitu::render
