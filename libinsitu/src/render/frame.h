#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "query/sampler.h"
#include "render/camera/camera.h"
#include "render/clip.h"
#include "render/light.h"
#include "render/path/path_settings.h"
#include "render/surface/isosurface.h"
#include "render/surface/outline.h"
#include "render/surface/triangle_surfaces.h"
#include "render/volume/volume.h"

namespace insitu::render {

/// All that a frame shows. What is not asked for is neither computed nor allocated.
struct FrameSettings {
  int width = 1024, height = 1024;
  Camera camera;
  /// Rays a pixel, see pixel_samples(), whose colours and alphas are averaged in linear light
  /// before the background comes behind. Images of depth and cells are those of the first. Paths
  /// that are traced are dealt out to the samples in turn, so there must be as many.
  int samples_per_pixel = 1;
  Color background{1, 1, 1}; ///< linear
  float background_alpha = 1;
  std::optional<VolumeSettings> volume;
  std::optional<PathTracingSettings> path_tracing; ///< of the volume, instead of marching
  std::vector<IsosurfaceSettings> isosurfaces;
  std::optional<BoundarySettings> boundary;
  std::vector<BodySettings> bodies;
  std::optional<OutlineSettings> outline;
  Lighting lighting;
  std::vector<Clip> clips;
  bool depth = false, cell = false; ///< images of these too
};

/// One of the meshes of a frame. Of several the settings are alike but for what is drawn of each:
/// volume, isosurfaces, boundary. Bodies and the outline are the first's alone.
struct FrameLayer {
  const query::Sampler& sampler;
  const FrameSettings& settings;
  Structures& structures;
};

/// Row 0 at the top, pixel x of row y at y * width + x. depth and cell stay empty unless asked for.
/// Counted as memory of frames, so they must not outlive the structures' core::Memory.
struct FrameImages {
  core::Image color;
  /// Distance along the pixel's ray, in mesh units, to where its opacity reaches a half; infinite
  /// where it never does.
  core::CountedVector<float> depth;
  /// The flat cell (see mesh::MeshView) there, -1 where there is none. Where volumes of several
  /// meshes lie, that of the one with the greatest optical depth.
  core::CountedVector<std::int64_t> cell;
  /// Of several layers, with an image of cells: which of them the cell is of.
  core::CountedVector<std::int32_t> layer;
};

struct FrameStatistics {
  std::int64_t rays = 0;
  std::int64_t samples = 0; ///< located for the volume
  std::int64_t skipped = 0; ///< samples in macrocells that nothing shows of
  double step = 0;          ///< of the volumes, the finest; 0 without one
  /// Macrocells where the volume's tolerance is not held; see StepLevels.
  std::int64_t unheld = 0;
  /// Of a culled volume: gridlets and stitching cells, and those that nothing shows of.
  std::int64_t primitives = 0, culled = 0;
  std::int64_t cells_tested = 0;
  std::int64_t evaluations = 0; ///< of fields inside cells, for isosurfaces
  std::int64_t hits = 0;        ///< of surfaces
  std::int64_t lit_hits = 0;    ///< of them, where there is lighting
  std::int64_t lit_samples = 0; ///< of the volume, by its gradient
  std::int64_t integrals = 0;   ///< stretches of the volume that were pre-integrated
  std::int64_t clipped = 0;     ///< rays that clips leave less of, or nothing
  std::int64_t shadow_rays = 0, occlusion_rays = 0;
  std::int64_t shadow_samples = 0; ///< located for the volume's shadow on surfaces
  PathCounts paths;                ///< of path tracing
  /// Of a frame of several processes, by this one, to others.
  std::int64_t bytes_sent = 0, parcels_sent = 0, exchanges = 0;
  double prepare_seconds = 0; ///< averages, value ranges, tables
  double seconds = 0;         ///< all

  void add(const SurfaceCounts& counts) {
    cells_tested += counts.cells_tested;
    evaluations += counts.evaluations;
    lit_hits += counts.lit;
    shadow_rays += counts.shadow_rays;
    occlusion_rays += counts.occlusion_rays;
    shadow_samples += counts.shadow_samples;
  }
  void add(const VolumeCounts& counts) {
    samples += counts.samples;
    skipped += counts.skipped;
    lit_samples += counts.lit;
    integrals += counts.integrals;
    shadow_rays += counts.shadow_rays;
  }
};

/// Draws the mesh as committed. Tiles of the image run in parallel; the image is the same to
/// the byte for any number of threads. Throws core::Error, INSITU_ERROR_ARGUMENT or
/// INSITU_ERROR_FIELD, if the settings do not fit.
FrameImages render_frame(const query::Sampler& sampler, const FrameSettings& settings,
                         Structures& structures, const core::Threads& threads,
                         FrameStatistics* statistics = nullptr);
/// Draws several meshes, one at least, blended by depth; see volume/volumes_together.h.
FrameImages render_frame(std::span<const FrameLayer> layers, const core::Threads& threads,
                         FrameStatistics* statistics = nullptr);
/// Whether there is a surface, or a line, of a mesh.
bool has_surfaces(const FrameSettings& settings);
/// Puts an image of colours times alpha over the background of the settings; its alpha then is
/// straight.
void put_over_background(core::Image& partial, const FrameSettings& settings,
                         const core::Threads& threads);
/// Draws a frame with structures for this frame alone.
FrameImages render_frame(const query::Sampler& sampler, const FrameSettings& settings,
                         const core::Threads& threads, core::Memory& memory,
                         FrameStatistics* statistics = nullptr);

} // namespace insitu::render
