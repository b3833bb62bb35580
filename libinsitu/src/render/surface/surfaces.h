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

/// Whether the light on some isosurface goes by central differences.
bool has_central_normals(const FrameSettings& settings);

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
  void trace(std::span<RayState> rays, IsosurfaceTile* tile, SurfaceCounts& counts) const {
    find(rays, tile, counts);
    finish(rays, counts);
  }
  /// The isosurfaces, if hits of a tile can be found side by side; otherwise null.
  const IsosurfaceTracer* tiled() const {
    return isosurfaces_ && isosurfaces_->is_exact() ? &*isosurfaces_ : nullptr;
  }

  // Of a frame of several meshes (surfaces_together.h), in this order.

  /// Rays of light meet the surfaces of `others` too, and the shadows of their volumes; they must
  /// outlive this. layer: SurfaceHit::layer of what is lit here.
  void join(std::int32_t layer, std::vector<const Surfaces*> others);
  /// What trace() makes before it is lit.
  void find(std::span<RayState> rays, IsosurfaceTile* tile, SurfaceCounts& counts) const;
  /// Colours and lights those of the hits that are of this layer.
  void light(std::span<RayState> rays, SurfaceCounts& counts) const;
  void add_lines(std::span<RayState> rays) const;

  // Of a frame of several processes (shared_surfaces.cpp), in this order.

  /// Adds to ray.hits the hits of a ray with isosurfaces and the boundary in this process's cells,
  /// in no order, with gradients, clearances and their own colours; where normals are central
  /// differences, without the first two.
  void find_own(std::span<RayState> rays, IsosurfaceTile* tile, SurfaceCounts& counts) const;
  /// The isosurfaces; null: none, or this process has no cells.
  const IsosurfaceTracer* isosurfaces() const { return isosurfaces_ ? &*isosurfaces_ : nullptr; }
  /// Of a hit of find_own() whose normal is of central differences, before it is sent.
  void set_gradient(SurfaceHit& hit, const Ray& ray, const math::Vec3d& gradient) const;
  /// Makes of the hits of all processes what trace() makes before they are lit, by whatever numbers
  /// their cells have.
  void put_in_order(std::span<RayState> rays) const;
  /// The hit's own colour, if it is not known yet where it is shaded: of a body.
  void set_color(SurfaceHit& hit) const;
  /// Lights these, and adds lines. Of several processes only without rays of light.
  void finish(std::span<RayState> rays, SurfaceCounts& counts) const {
    light(rays, counts);
    add_lines(rays);
  }

  // With rays of light in place of finish().

  /// A hit to be lit, and the ray that sees it. seed: of its random numbers.
  struct Seen {
    const Ray* ray;
    std::uint64_t seed;
    SurfaceHit* hit;
  };
  /// Lights hits. Of several processes only without rays of light.
  void light(std::span<const Seen> seen, SurfaceCounts& counts) const;
  bool lights_hits() const { return shader_.has_value(); }
  /// Whose rays are to be followed; null: there are none.
  const Shader* light_shader() const {
    return shader_ && shader_->sends_rays() ? &*shader_ : nullptr;
  }
  /// Adds the hits that are in order.
  void see(std::span<RayState> rays, std::vector<Seen>& seen) const;
  SurfacePoint point_of(const Seen& seen, SurfaceCounts& counts) const;
  static void shade(SurfaceHit& hit, const Color& factor) {
    hit.color = {factor.r * hit.color.r, factor.g * hit.color.g, factor.b * hit.color.b};
  }
  /// Sets the hits of rays of light in this process's cells, at most RayLanes::most rays, as they
  /// are. Returns the rays that an opaque one ends, a bit each, whose hits say nothing else.
  unsigned collect(std::span<const LightRay> rays, std::vector<SurfaceHit>* hits,
                   SurfaceCounts& counts) const;
  /// What comes through the hits of all processes, and bodies.
  double open(const LightRay& ray, std::vector<SurfaceHit>& hits) const;
  /// Or null.
  const VolumeShadow* volume_shadow() const { return volume_shadow_ ? &*volume_shadow_ : nullptr; }

  double open(const Ray& ray, double t_max) const override;
  void meet(const Ray& ray, core::FunctionRef<bool(float opacity)> ends, std::uint64_t seed,
            double& t, Color& color) const override;

private:
  void find(const Ray& ray, const std::vector<Stretch>* stays, std::vector<SurfaceHit>& hits,
            SurfaceCounts& counts) const;
  struct LightScratch;
  static LightScratch& scratch();
  const std::vector<Stretch>* stays_of(const RayState& state) const {
    return settings_.clips.empty() ? nullptr : &state.stays;
  }
  static math::Vec3d normal_of(const math::Vec3d& gradient, const Ray& ray);
  void take_boundary(std::vector<SurfaceHit>& hits, std::vector<SurfaceHit>& boundary) const;
  void answer(LightScratch& scratch, SurfaceCounts& counts) const;
  Color color(const SurfaceHit& hit) const;
  void open(std::span<LightRay> rays, SurfaceCounts& counts) const;
  void open_here(std::span<LightRay> rays, SurfaceCounts& counts) const;
  double through_volumes(const Ray& ray, double t_max, double open, SurfaceCounts& counts) const;
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
  std::int32_t layer_ = 0;
  std::vector<const Surfaces*> others_; ///< of other meshes
};

} // namespace insitu::render
