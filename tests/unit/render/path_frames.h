#pragma once

#include <cmath>

#include "unit/render/path_mesh.h"

/// What tests of path traced frames draw.
namespace insitu::test {

using render::FrameSettings;
using render::Light;
using render::VolumeSettings;

inline double x_of(const Vec3d& p) {
  return p.x;
}
inline double one_of(const Vec3d&) {
  return 1.0;
}
inline double blob_of(const Vec3d& p) {
  const Vec3d d = p - Vec3d{0.6, 0.5, 0.4};
  return std::exp(-20 * dot(d, d));
}

inline VolumeSettings volume_of(const render::ScalarField& field, double first, double last) {
  VolumeSettings v{field, medium_of({0.9f, 0.7f, 0.4f}, first, last)};
  v.unit_distance = 0.2;
  return v;
}

/// Of a blob, with all kinds of lights.
inline FrameSettings blob_frame(const render::ScalarField& blob, int size) {
  FrameSettings s = box_frame(size);
  s.volume = volume_of(blob, 0, 0.9);
  s.path_tracing.emplace().samples = 4;
  s.path_tracing->anisotropy = 0.3;
  using Kind = Light::Kind;
  s.lighting.lights = {{Kind::dome, {}, {0.3f, 0.4f, 0.5f}},
                       {Kind::directional, {1, 2, 1}, {1, 1, 1}},
                       {Kind::point, {1.5, 0.5, 0.5}, {1, 1, 1}},
                       {Kind::head, {}, {0.2f, 0.2f, 0.2f}}};
  return s;
}

} // namespace insitu::test
