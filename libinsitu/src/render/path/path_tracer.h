#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/camera/ray_state.h"
#include "render/clip.h"
#include "render/path/medium.h"
#include "render/path/path_lights.h"
#include "render/path/path_settings.h"
#include "render/structures/place_value.h"
#include "render/structures/structures.h"
#include "render/volume/volume.h"

namespace insitu::render {

/// The majorants of a volume that is path traced: those of the settings, or the structures'. Throws
/// core::Error (INSITU_ERROR_FIELD) for a component that the field does not have.
const Majorants& path_majorants(const query::Sampler& sampler, const VolumeSettings& volume,
                                const PathTracingSettings& settings, Structures& structures);

struct Path;

/// Follows light through media, those of a frame's volumes, without bias: free flights by delta
/// tracking (Woodcock et al. 1965) through the majorants of macrocells, transmittances of shadow
/// rays by ratio tracking (Novak et al. 2014). Each medium has flights of its own, and that which
/// collides first decides: where media lie in one place extinctions add up. Dome lights are met by
/// the paths that leave the medium, all others by a shadow ray from each collision, so none counts
/// twice. Surfaces end the rays from the camera, a translucent one with a chance of its opacity;
/// scattered light and shadow rays pass them by, unless set_surfaces() lets them meet: then what
/// light a surface sends into the medium is what is seen of it. Where a ray leaves the medium
/// without a collision it shows the surface or background behind.
class PathTracer {
public:
  /// Paths of so many pixels along each axis are traced together, which is the order of sums.
  static constexpr int tile_side = 16;

  /// The clips and settings.sums must outlive it. Throws core::Error (INSITU_ERROR_ARGUMENT) for
  /// what is out of range.
  PathTracer(const PathTracingSettings& settings, const Camera& camera,
             const std::vector<Light>& lights, const std::vector<Clip>& clips);
  /// Adds a medium; at least one before paths are traced. The sampler's mesh (of which it may hold
  /// a part, see query::Sampler::among) must outlive this. See Medium. layer: of the frame, see
  /// RayState::depth_layer.
  void add(const query::Sampler& sampler, const VolumeSettings& volume, const Majorants& majorants,
           const core::Threads& threads, core::Memory& memory, std::int32_t layer);

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
  /// left to blend. RayState::pixel with the sample keys the random numbers. Thread-safe for
  /// different pixels; what a pixel gets depends on the other rays by the order of sums alone.
  void trace(std::span<RayState> rays, PathCounts& counts) const;

  /// In the order in which they were added, which Path::medium counts.
  std::span<const Medium> media() const { return media_; }

private:
  friend class PathWave;

  void answer(std::span<Path> paths) const;
  void answer_values(std::span<Path> paths) const;
  /// Narrows [near, far] to where the ray is within the media's bounds; false: nowhere.
  bool clip_to_bounds(const Ray& ray, double& near, double& far) const;

  PathTracingSettings settings_;
  std::int64_t first_sample_ = 0, stride_ = 1;
  std::vector<Medium> media_;
  std::vector<std::int32_t> layers_; ///< of these
  mesh::Box bounds_{}; ///< of these
  PathLights lights_;
  const std::vector<Clip>& clips_;
  const SceneSurfaces* surfaces_ = nullptr;
};

} // namespace insitu::render
