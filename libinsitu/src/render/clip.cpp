#include "render/clip.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

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
    return stretch_in_box(ray, clip.point, clip.vector);
  case Clip::Kind::sphere:
    break;
  }
  return in_sphere(clip, ray);
}

} // namespace

std::optional<Stretch> stretch_in_box(const Ray& ray, const Vec3d& low, const Vec3d& high) {
  Stretch in{-infinity, infinity};
  for (int a = 0; a < 3; ++a) {
    const double to_low = low[a] - ray.origin[a], to_high = high[a] - ray.origin[a];
    const double d = ray.direction[a];
    if (d == 0) {
      if (to_low > 0 || to_high < 0)
        return std::nullopt;
      continue;
    }
    in.from = std::max(in.from, (d > 0 ? to_low : to_high) / d);
    in.to = std::min(in.to, (d > 0 ? to_high : to_low) / d);
  }
  return in.from <= in.to ? std::optional(in) : std::nullopt;
}

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

namespace {

using Polygon = std::vector<Vec3d>;

/// The faces of a box; those of one without extent are flat.
std::vector<Polygon> box_faces(const Vec3d& low, const Vec3d& high) {
  std::vector<Polygon> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (const Vec3d* side : {&low, &high}) {
      Polygon face;
      for (const auto& [b, c] :
           {std::pair{&low, &low}, {&high, &low}, {&high, &high}, {&low, &high}}) {
        Vec3d p;
        p[axis] = (*side)[axis];
        p[(axis + 1) % 3] = (*b)[(axis + 1) % 3];
        p[(axis + 2) % 3] = (*c)[(axis + 2) % 3];
        face.push_back(p);
      }
      faces.push_back(std::move(face));
    }
  return faces;
}

/// Points of a plane in the order of a convex polygon's corners.
void sort_around(Polygon& points, const Vec3d& normal) {
  Vec3d middle;
  for (const Vec3d& p : points)
    middle += (1.0 / double(points.size())) * p;
  int least = 0;
  for (int a = 1; a < 3; ++a)
    least = std::fabs(normal[a]) < std::fabs(normal[least]) ? a : least;
  Vec3d axis;
  axis[least] = 1;
  const Vec3d u = cross(normal, axis), v = cross(normal, u) / std::sqrt(dot(normal, normal));
  const auto angle = [&](const Vec3d& p) {
    return std::atan2(dot(p - middle, v), dot(p - middle, u));
  };
  std::sort(points.begin(), points.end(),
            [&](const Vec3d& a, const Vec3d& b) { return angle(a) < angle(b); });
}

/// Keeps what is behind a plane (Sutherland, Hodgman 1974, face by face) and closes the cut.
void cut(std::vector<Polygon>& faces, const Vec3d& point, const Vec3d& normal) {
  Polygon lid;
  std::vector<Polygon> kept;
  for (const Polygon& face : faces) {
    Polygon rest;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Vec3d &a = face[i], &b = face[(i + 1) % face.size()];
      const double above_a = dot(a - point, normal), above_b = dot(b - point, normal);
      if (above_a <= 0)
        rest.push_back(a);
      if (above_a == 0)
        lid.push_back(a);
      if ((above_a < 0 && above_b > 0) || (above_a > 0 && above_b < 0)) {
        rest.push_back(a + (above_a / (above_a - above_b)) * (b - a));
        lid.push_back(rest.back());
      }
    }
    if (!rest.empty())
      kept.push_back(std::move(rest));
  }
  faces = std::move(kept);
  if (lid.size() < 3)
    return;
  sort_around(lid, normal);
  lid.erase(std::unique(lid.begin(), lid.end(),
                        [](const Vec3d& a, const Vec3d& b) {
                          return a.x == b.x && a.y == b.y && a.z == b.z;
                        }),
            lid.end());
  faces.push_back(std::move(lid));
}

} // namespace

std::vector<Vec3d> clipped_corners(const std::vector<Clip>& clips, const Vec3d& low,
                                   const Vec3d& high) {
  Vec3d from = low, to = high;
  for (const Clip& clip : clips) {
    if (clip.kind == Clip::Kind::plane || !clip.keep_inside)
      continue;
    for (int a = 0; a < 3; ++a) {
      const bool is_box = clip.kind == Clip::Kind::box;
      from[a] = std::max(from[a], is_box ? clip.point[a] : clip.point[a] - clip.radius);
      to[a] = std::min(to[a], is_box ? clip.vector[a] : clip.point[a] + clip.radius);
      if (from[a] > to[a])
        return {};
    }
  }
  std::vector<Polygon> faces = box_faces(from, to);
  for (const Clip& clip : clips)
    if (clip.kind == Clip::Kind::plane)
      cut(faces, clip.point, clip.vector);
  std::vector<Vec3d> corners;
  for (const Polygon& face : faces)
    corners.insert(corners.end(), face.begin(), face.end());
  return corners;
}

} // namespace insitu::render
