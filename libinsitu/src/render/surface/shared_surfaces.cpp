#include <algorithm>
#include <cmath>

#include "render/surface/surfaces.h"
#include "render/surface/tiles/isosurface_rays.h"

/// The surfaces of a frame of several processes: each finds the hits in its own cells.
namespace insitu::render {

bool has_central_normals(const FrameSettings& settings) {
  return settings.lighting.enabled &&
         std::any_of(
             settings.isosurfaces.begin(), settings.isosurfaces.end(),
             [](const IsosurfaceSettings& surface) { return surface.normals == Normals::central; });
}

void Surfaces::find_own(std::span<RayState> rays, IsosurfaceTile* tile,
                        SurfaceCounts& counts) const {
  thread_local std::vector<SurfaceHit> boundary; // kept for the thread's life
  const auto width = std::uint64_t(settings_.width);
  IsosurfaceTracer::LastCell last;
  for (RayState& state : rays) {
    if (isosurfaces_ && tile) {
      tile->raw_hits(int(state.pixel % width), int(state.pixel / width), state.hits);
    } else if (isosurfaces_) {
      isosurfaces_->collect(state.ray, state.hits, counts, stays_of(state));
      isosurfaces_->complete(state.hits, last);
    }
    const auto at = [&](const SurfaceHit& hit) {
      return state.ray.origin + hit.t * state.ray.direction;
    };
    for (SurfaceHit& hit : state.hits) {
      hit.color = isosurfaces_->color(hit);
      if (shader_ && !isosurfaces_->is_central(hit.surface))
        set_gradient(hit, state.ray, isosurfaces_->gradient(hit, at(hit), counts));
    }
    if (settings_.boundary) {
      boundary.clear();
      triangles_->collect_boundary(state.ray, boundary, stays_of(state));
      for (SurfaceHit& hit : boundary) {
        hit.color = triangles_->color(hit);
        set_gradient(hit, state.ray, hit.gradient);
        state.hits.push_back(hit);
      }
    }
  }
}

void Surfaces::set_gradient(SurfaceHit& hit, const Ray& ray, const math::Vec3d& gradient) const {
  hit.gradient = gradient;
  if (light_shader())
    hit.clearance =
        clearance(hit, ray.origin + hit.t * ray.direction, normal_of(hit.gradient, ray));
}

/// Parts hits with the boundary from those with isosurfaces.
void Surfaces::take_boundary(std::vector<SurfaceHit>& hits,
                             std::vector<SurfaceHit>& boundary) const {
  boundary.clear();
  std::erase_if(hits, [&](const SurfaceHit& hit) {
    if (hit.surface >= first_triangle_surface_)
      boundary.push_back(hit);
    return hit.surface >= first_triangle_surface_;
  });
}

void Surfaces::put_in_order(std::span<RayState> rays) const {
  thread_local std::vector<SurfaceHit> boundary; // kept for the thread's life
  for (RayState& state : rays) {
    take_boundary(state.hits, boundary);
    IsosurfaceTracer::put_in_order(state.hits);
    if (triangles_)
      triangles_->add(state.ray, boundary, state.hits, stays_of(state));
  }
}

unsigned Surfaces::collect(std::span<const LightRay> rays, std::vector<SurfaceHit>* hits,
                           SurfaceCounts& counts) const {
  const auto is_opaque = [](const SurfaceHit& hit) { return hit.opacity >= 1; };
  if (isosurfaces_)
    isosurfaces_->collect(rays, hits, counts);
  unsigned ended = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!isosurfaces_)
      hits[i].clear();
    bool has_ended = std::any_of(hits[i].begin(), hits[i].end(), is_opaque);
    if (settings_.boundary && !has_ended) {
      triangles_->collect_boundary(rays[i].ray, hits[i], rays[i].stays);
      has_ended = std::any_of(hits[i].begin(), hits[i].end(), is_opaque);
    }
    ended |= unsigned(has_ended) << i;
  }
  return ended;
}

double Surfaces::open(const LightRay& ray, std::vector<SurfaceHit>& hits) const {
  thread_local std::vector<SurfaceHit> boundary; // kept for the thread's life
  take_boundary(hits, boundary);
  IsosurfaceTracer::put_in_order(hits);
  double open = open_past(hits);
  if (!triangles_ || !(open > 0))
    return open;
  hits.clear();
  triangles_->add(ray.ray, boundary, hits, ray.stays);
  return open * open_past(hits);
}

} // namespace insitu::render
