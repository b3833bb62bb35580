#pragma once

#include <cstdint>
#include <vector>

#include "math/vec.h"
#include "render/color/color.h"

namespace insitu::render {

/// One crossing of a ray with a surface.
struct SurfaceHit {
  double t = 0;
  std::int64_t cell = -1;     ///< flat; of a body: -1
  std::int32_t surface = 0;   ///< isovalues of all settings, then the boundary, bodies; -1: a line
  std::int32_t layer = 0;     ///< of a frame of several meshes: whose surface it is
  std::int64_t triangle = -1; ///< of a triangle mesh
  float opacity = 1;
  double extent = 0;      ///< of the ray in the cell, to tell hits apart
  math::Vec3d parametric; ///< in the cell; of a triangle: weights of its second and third vertex
  math::Vec3d gradient;   ///< across the surface, of any length
  Color color;            ///< its own at first, then lit
  // Of a frame of several processes, where rays of light start; see SurfacePoint::clearance.
  std::int32_t process = -1;      ///< that found the hit
  std::int64_t process_cell = -1; ///< the flat cell there
  double clearance = 0;
};

/// The part of light that comes past hits.
inline double open_past(const std::vector<SurfaceHit>& hits) {
  double open = 1;
  for (const SurfaceHit& hit : hits)
    open *= 1.0 - double(hit.opacity);
  return open;
}

struct SurfaceCounts {
  std::int64_t cells_tested = 0;
  std::int64_t evaluations = 0; ///< of fields inside cells, each with an inverse map
  std::int64_t lit = 0;         ///< hits that a viewer sees and light falls on
  std::int64_t shadow_rays = 0, occlusion_rays = 0;
  std::int64_t shadow_samples = 0; ///< located for the volume's shadow

  SurfaceCounts& operator+=(const SurfaceCounts& b) {
    cells_tested += b.cells_tested;
    evaluations += b.evaluations;
    lit += b.lit;
    shadow_rays += b.shadow_rays;
    occlusion_rays += b.occlusion_rays;
    shadow_samples += b.shadow_samples;
    return *this;
  }
};

} // namespace insitu::render
