#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "render/camera/ray_state.h"
#include "render/frame.h"
#include "render/surface/isosurface.h"
#include "render/surface/shade.h"
#include "render/surface/tiles/isosurface_tile.h"
#include "render/volume/volume_shadow.h"

namespace insitu::render {

/// All surfaces of a frame, cut by its clips and lit.
class Surfaces final : public SceneSurfaces {
public:
  /// Whether hits are found where they are shaded, or the mesh is spread over processes
  /// (render/processes): one of them then shades a ray's hits, and all find some.
  enum class Parts { whole, shared };

  /// The settings and the structures must outlive it.
  Surfaces(const query::Sampler& sampler, const FrameSettings& settings, Structures& structures,
           Parts parts = Parts::whole);

  /// Sets ray.hits of each ray, in depth order, up to and including the first opaque one.
  /// ray.pixel and, if the frame has clips, ray.stays must be set. Random numbers depend on the
  /// pixel and the ray's sample. tile: holds the isosurfaces' hits of the pixels, or null.
  void trace(std::span<RayState> rays, IsosurfaceTile* tile, SurfaceCounts& counts) const;
  /// The isosurfaces, if hits of a tile can be found side by side; otherwise null.
  const IsosurfaceTracer* tiled() const {
    return isosurfaces_ && isosurfaces_->is_exact() ? &*isosurfaces_ : nullptr;
  }

  /// Of a frame of several processes. find_own() adds to ray.hits the hits of a ray with
  /// isosurfaces in this process's cells, in no order, with gradients and their own colours;
  /// finish() makes what trace() leaves of the hits of all processes, by whatever numbers their
  /// cells have.
  void find_own(std::span<RayState> rays, IsosurfaceTile* tile, SurfaceCounts& counts) const;
  void finish(std::span<RayState> rays, SurfaceCounts& counts) const;

  double open(const Ray& ray, double t_max) const override;
  void meet(const Ray& ray, core::FunctionRef<bool(float opacity)> ends, std::uint64_t seed,
            double& t, Color& color) const override;

private:
  void find(const Ray& ray, const std::vector<Stretch>* stays, std::vector<SurfaceHit>& hits,
            SurfaceCounts& counts) const;
  /// A hit to be lit, and the ray that sees it. seed: of its random numbers.
  struct Seen {
    const Ray* ray;
    std::uint64_t seed;
    SurfaceHit* hit;
  };
  struct LightScratch;
  static LightScratch& scratch();
  void light(std::span<const Seen> seen, SurfaceCounts& counts) const;
  void light(std::span<RayState> rays, SurfaceCounts& counts) const;
  const std::vector<Stretch>* stays_of(const RayState& state) const {
    return settings_.clips.empty() ? nullptr : &state.stays;
  }
  SurfacePoint point_of(const Seen& seen, SurfaceCounts& counts) const;
  void answer(LightScratch& scratch, SurfaceCounts& counts) const;
  Color color(const SurfaceHit& hit) const;
  void open(std::span<LightRay> rays, SurfaceCounts& counts) const;
  double clearance(const SurfaceHit& hit, const math::Vec3d& position,
                   const math::Vec3d& normal) const;

  query::Sampler sampler_;
  const FrameSettings& settings_;
  double diagonal_;
  Parts parts_;
  std::optional<IsosurfaceTracer> isosurfaces_;
  std::int32_t first_triangle_surface_ = 0;
  std::optional<TriangleSurfaces> triangles_;
  std::optional<Outline> outline_;
  std::optional<Shader> shader_;              ///< none: plain colours
  std::optional<VolumeShadow> volume_shadow_; ///< if asked for
};

} // namespace insitu::render
