#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "render/camera/camera.h"
#include "render/clip.h"
#include "render/surface/isosurface.h"

namespace insitu::render {

/// Opacity from which on a ray is not followed further.
constexpr float saturated = 0.999f;

/// Adds what lies behind: a colour that hides a of what comes after it. color is times alpha. As
/// Rgba its own fourth number says nothing: the next sample waits for alpha, so that stays apart.
template <class Rgb>
void blend_behind(Rgb& color, float& alpha, const Rgb& c, float a) {
  const float weight = (1.0f - alpha) * a;
  color = color + weight * c;
  alpha += weight;
}

/// What a ray has gathered between two of its hits, or before the first one, or behind the last.
struct RayPiece {
  std::uint32_t hits; ///< so many of the ray's hits lie before it
  float alpha;
  Color color; ///< times alpha
};

/// What a volume adds to a ray over a stretch of it.
struct VolumeStretch {
  double from, to; ///< from < to
  float alpha;     ///< above 0
  Color color;     ///< not times alpha
  std::int64_t cell = -1;
};

/// What a ray has gathered, front to back, and where it stands.
struct RayState {
  Ray ray;
  std::uint64_t pixel = 0;  ///< its number in the image
  std::uint64_t sample = 0; ///< which of the pixel's samples, see pixel_samples()
  Color color;              ///< times alpha
  float alpha = 0;
  std::int64_t next = 0, end = 0; ///< lattice indices of its volume samples
  std::int64_t first = 0;         ///< of them
  double near = 0, far = 0;       ///< where it enters and leaves the volume's bounds
  bool may_skip = false;          ///< by macrocells
  bool is_thin = false;           ///< takes one sample for all from near to far
  std::vector<Stretch> stays;     ///< what the frame's clips leave of it; empty without clips
  std::vector<SurfaceHit> hits;
  std::size_t next_hit = 0;
  bool in_pieces = false;                               ///< hits end a piece, and are not blended
  std::vector<RayPiece> pieces;                         ///< those that have ended
  bool keeps_stretches = false;                         ///< what is blended is kept too
  std::vector<VolumeStretch> stretches;                 ///< in order
  std::int64_t lit = 0, integrals = 0, shadow_rays = 0; ///< see VolumeCounts
  /// Where alpha reached a half, and the flat cell there; see FrameImages.
  double depth = HUGE_VAL;
  std::int64_t depth_cell = -1;
  std::int32_t depth_layer = 0;  ///< of a frame of several meshes: whose cell that is
  std::int32_t volume_layer = 0; ///< whose volume it is that stretches are blended of

  /// A ray that has gathered nothing yet; vectors keep their memory.
  void begin(const Ray& r) {
    ray = r;
    color = {};
    alpha = 0;
    next = end = first = 0;
    near = far = 0;
    may_skip = is_thin = false;
    stays.clear();
    hits.clear();
    next_hit = 0;
    in_pieces = false;
    pieces.clear();
    keeps_stretches = false;
    stretches.clear();
    lit = integrals = shadow_rays = 0;
    depth = HUGE_VAL;
    depth_cell = -1;
    depth_layer = volume_layer = 0;
  }

  bool is_saturated() const { return alpha >= saturated; }
  void blend(const Color& c, float a) { blend_behind(color, alpha, c, a); }
  /// A medium in a cell that absorbs a of the light over a stretch of the ray.
  void blend_stretch(const Color& c, float a, double from, double to, std::int64_t cell) {
    if (keeps_stretches && a > 0 && to > from)
      stretches.push_back({from, to, a, c, cell});
    const float before = alpha;
    blend(c, a);
    if (before < 0.5f && alpha >= 0.5f) {
      // Transmittance decays exponentially within the stretch.
      const double x = a < 1 ? std::log(0.5 / (1.0 - before)) / std::log1p(-double(a)) : 0.0;
      depth = from + std::fmin(x, 1.0) * (to - from);
      depth_cell = cell;
      depth_layer = volume_layer;
    }
  }
  /// The next piece begins with nothing gathered.
  void end_piece() {
    if (alpha > 0)
      pieces.push_back({std::uint32_t(next_hit), alpha, color});
    color = {};
    alpha = 0;
  }
  void blend(const RayPiece& piece) {
    color = color + (1.0f - alpha) * piece.color;
    alpha += (1.0f - alpha) * piece.alpha;
  }
  void blend_next_hit() {
    if (in_pieces) {
      end_piece();
      ++next_hit;
      return;
    }
    const SurfaceHit& hit = hits[next_hit++];
    const bool see_through = alpha < 0.5f;
    blend(hit.color, hit.opacity);
    if (see_through && alpha >= 0.5f) {
      depth = hit.t;
      depth_cell = hit.cell;
      depth_layer = hit.layer;
    }
  }
};

} // namespace insitu::render
