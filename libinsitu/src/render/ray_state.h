#pragma once

#include <cstdint>
#include <vector>

#include "render/camera.h"
#include "render/clip.h"
#include "render/isosurface.h"

namespace insitu::render {

/// Opacity from which on a ray is not followed further.
constexpr float saturated = 0.999f;

/// What a ray has gathered, front to back, and where it stands.
struct RayState {
  Ray ray;
  Color color; ///< times alpha
  float alpha = 0;
  std::int64_t next = 0, end = 0; ///< lattice indices of its volume samples
  std::int64_t first = 0;         ///< of them
  double near = 0, far = 0;       ///< where it enters and leaves the volume's bounds
  bool may_skip = false;          ///< by macrocells
  bool is_thin = false;           ///< takes one sample for all from near to far
  std::vector<Stretch> stays;     ///< what the frame's clips leave of it; empty without clips
  std::vector<SurfaceHit> hits;
  std::size_t next_hit = 0;

  bool is_saturated() const { return alpha >= saturated; }
  void blend(const Color& c, float a) {
    const float weight = (1.0f - alpha) * a;
    color = color + weight * c;
    alpha += weight;
  }
  void blend_next_hit() {
    const SurfaceHit& hit = hits[next_hit++];
    blend(hit.color, hit.opacity);
  }
};

} // namespace insitu::render
