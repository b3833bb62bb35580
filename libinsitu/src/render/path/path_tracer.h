#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/camera/ray_state.h"
#include "render/clip.h"
#include "render/path/medium.h"
#include "render/path/path_lights.h"
#include "render/path/path_settings.h"
#include "render/structures/structures.h"
#include "render/volume/volume.h"

namespace insitu::render {

/// How fine the grid of majorants is.
inline MacrocellFineness fineness_of(const PathTracingSettings& settings) {
  return {settings.cells_per_macrocell, PathTracingSettings::most_macrocells};
}

/// Follows light through a volume, without bias: free flights by delta tracking (Woodcock et al.
/// 1965) through the majorants of macrocells, transmittances of shadow rays by ratio tracking
/// (Novak et al. 2014). Dome lights are met by the paths that leave the medium, all others by a
/// shadow ray from each collision, so none counts twice. Surfaces end the rays from the camera, a
/// translucent one with a chance of its opacity; scattered light and shadow rays pass them by,
/// unless set_surfaces() lets them meet: then what light a surface sends into the medium is what
/// is seen of it.
/// Where a ray leaves the medium without a collision it shows the surface or background behind.
class PathTracer {
public:
  /// Of a volume's settings those of marching (steps, lighting) are not used. Asks structures for
  /// majorants, and for what is not culled if that is asked for (Culling::always). The sampler's
  /// mesh, the clips and settings.sums must outlive it. Throws core::Error (INSITU_ERROR_ARGUMENT
  /// or INSITU_ERROR_FIELD) for what is out of range.
  PathTracer(const query::Sampler& sampler, const VolumeSettings& volume,
             const PathTracingSettings& settings, const Camera& camera,
             const std::vector<Light>& lights, const std::vector<Clip>& clips,
             Structures& structures, const core::Threads& threads);

  /// Surfaces that shadow rays and scattered light meet too; they must outlive this. None: they
  /// pass.
  void set_surfaces(const SceneSurfaces* surfaces) { surfaces_ = surfaces; }

  /// Lets the paths of a pixel be those that have the numbers first, first + stride, ... among all
  /// that the frame has. depth: whether they tell the depth.
  void set_samples(std::int64_t count, std::int64_t first, std::int64_t stride, bool depth) {
    settings_.samples = int(count);
    settings_.depth = depth;
    first_sample_ = first;
    stride_ = stride;
  }

  /// Draws pixels: rays, which come with their surface hits, get colour and alpha, and no hit is
  /// left to blend. pixels: the number of each in the image, which with the sample keys the random
  /// numbers. Thread-safe for different pixels; what a pixel gets depends on nothing else.
  void trace(std::span<RayState> rays, std::span<const std::int64_t> pixels,
             PathCounts& counts) const;

  /// Where collisions are looked for, if culling is asked for; else null.
  const query::CulledCells* culled() const { return culled_; }

private:
  friend class PathWave;

  /// Narrows [near, far] to where the ray is within the mesh's bounds; false: nowhere.
  bool clip_to_bounds(const Ray& ray, double& near, double& far) const;

  PathTracingSettings settings_;
  std::int64_t first_sample_ = 0, stride_ = 1;
  const query::CulledCells* culled_;
  Medium medium_;
  PathLights lights_;
  const std::vector<Clip>& clips_;
  const SceneSurfaces* surfaces_ = nullptr;
  math::Vec3d low_, high_;
  query::LocateOptions options_;
};

} // namespace insitu::render
