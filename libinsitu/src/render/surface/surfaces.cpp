#include "render/surface/surfaces.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "render/path/path_tracer.h"
#include "render/volume/ray_step.h"

namespace insitu::render {

namespace {

using math::Vec3d;

/// Above a surface by this part of the cell's thickness, a ray does not meet it again for rounding:
/// roots are found to 1e-11 of it.
constexpr double clearance_of_thickness = 1e-5;
/// A position is rounded to 2^-53 of its largest coordinate, a few times over.
constexpr double clearance_of_coordinates = 0x1p-48;

} // namespace

Surfaces::Surfaces(const query::Sampler& sampler, const FrameSettings& settings,
                   Structures& structures)
    : sampler_(sampler), settings_(settings), diagonal_(mesh_diagonal(sampler)) {
  if (!settings.isosurfaces.empty())
    isosurfaces_.emplace(sampler, settings.isosurfaces, structures, settings.lighting.enabled);
  if (isosurfaces_)
    first_triangle_surface_ = isosurfaces_->surface_count();
  if (settings.boundary || !settings.bodies.empty())
    triangles_.emplace(sampler, settings.boundary, settings.bodies, first_triangle_surface_,
                       structures);
  if (settings.outline) {
    const mesh::Box box = sampler.facts().bounds;
    outline_.emplace(*settings.outline, settings.camera, settings.width, settings.height, box.low,
                     box.high, structures.memory());
  }
  if (settings.lighting.enabled)
    shader_.emplace(settings.lighting, 0.1 * diagonal_);
  if (!settings.lighting.volume_shadows || !settings.volume)
    return;
  const VolumeSettings& volume = *settings.volume;
  if (settings.path_tracing)
    volume_shadow_.emplace(
        sampler, volume, settings.path_tracing->density,
        &structures.majorants(volume.field, volume.function, fineness_of(*settings.path_tracing)),
        settings.clips);
  else
    volume_shadow_.emplace(sampler, volume, 1.0,
                           volume_structures(sampler, volume,
                                             std::int64_t(settings.width) * settings.height,
                                             structures)
                               .majorants,
                           settings.clips);
}

void Surfaces::find(const Ray& ray, const std::vector<Stretch>* stays,
                    std::vector<SurfaceHit>& hits, SurfaceCounts& counts) const {
  hits.clear();
  if (isosurfaces_)
    isosurfaces_->trace(ray, hits, counts, stays);
  if (triangles_)
    triangles_->trace(ray, hits, stays);
}

void Surfaces::trace(RayState& state, std::uint64_t pixel, IsosurfaceTile* tile,
                     SurfaceCounts& counts) const {
  const std::vector<Stretch>* const stays = settings_.clips.empty() ? nullptr : &state.stays;
  if (tile) {
    tile->hits(int(pixel % std::uint64_t(settings_.width)),
               int(pixel / std::uint64_t(settings_.width)), state.hits);
    if (triangles_)
      triangles_->trace(state.ray, state.hits, stays);
  } else {
    find(state.ray, stays, state.hits, counts);
  }
  std::uint64_t index = 0;
  for (SurfaceHit& hit : state.hits) {
    hit.color = color(hit);
    if (shader_)
      light(state.ray, core::splitmix64(pixel ^ (state.sample << 32)) + index++, hit, counts);
  }
  if (outline_)
    outline_->add(int(pixel % std::uint64_t(settings_.width)),
                  int(pixel / std::uint64_t(settings_.width)), state.ray, state.hits);
}

Color Surfaces::color(const SurfaceHit& hit) const {
  return hit.surface < first_triangle_surface_ ? isosurfaces_->color(hit) : triangles_->color(hit);
}

void Surfaces::light(const Ray& ray, std::uint64_t seed, SurfaceHit& hit,
                     SurfaceCounts& counts) const {
  ++counts.lit;
  SurfacePoint at;
  at.position = ray.origin + hit.t * ray.direction;
  at.to_viewer = -ray.direction;
  // Scaled first: gradients may be as small as their field's values.
  const Vec3d g = hit.surface < first_triangle_surface_
                      ? isosurfaces_->gradient(hit, at.position, counts)
                      : hit.gradient;
  const double largest = std::max({std::fabs(g.x), std::fabs(g.y), std::fabs(g.z)});
  if (largest > 0 && std::isfinite(largest)) {
    const Vec3d n = g / largest;
    at.normal = n / std::copysign(std::sqrt(dot(n, n)), -dot(n, ray.direction));
  } else {
    at.normal = at.to_viewer; // without a direction it faces the viewer
  }
  at.seed = seed;
  if (shader_->sends_rays())
    at.clearance = clearance(hit, at.position, at.normal);
  const Color factor = (*shader_)(
      at,
      [&](const Ray& to, double t_max) {
        const double left = open(to, t_max, counts);
        return volume_shadow_ && left > 0
                   ? left * volume_shadow_->through(to, t_max, counts.shadow_samples)
                   : left;
      },
      counts);
  hit.color = {factor.r * hit.color.r, factor.g * hit.color.g, factor.b * hit.color.b};
}

/// How much light surfaces let through.
double Surfaces::open(const Ray& ray, double t_max, SurfaceCounts& counts) const {
  thread_local std::vector<Stretch> stays; // kept for the thread's life
  thread_local std::vector<SurfaceHit> hits;
  clip_ray(settings_.clips, ray, 0, t_max, stays);
  find(ray, &stays, hits, counts);
  double through = 1;
  for (const SurfaceHit& hit : hits)
    through *= 1.0 - double(hit.opacity);
  return through;
}

double Surfaces::open(const Ray& ray, double t_max) const {
  SurfaceCounts none;
  return open(ray, t_max, none);
}

void Surfaces::meet(const Ray& ray, core::FunctionRef<bool(float)> ends, std::uint64_t seed,
                    double& t, Color& color_seen) const {
  thread_local std::vector<Stretch> stays; // kept for the thread's life
  thread_local std::vector<SurfaceHit> hits;
  SurfaceCounts none;
  t = HUGE_VAL;
  clip_ray(settings_.clips, ray, 0, HUGE_VAL, stays);
  find(ray, &stays, hits, none);
  for (SurfaceHit& hit : hits)
    if (hit.opacity >= 1 || ends(hit.opacity)) {
      hit.color = color(hit);
      if (shader_)
        light(ray, seed, hit, none);
      t = hit.t;
      color_seen = hit.color;
      return;
    }
}

double Surfaces::clearance(const SurfaceHit& hit, const Vec3d& position,
                           const Vec3d& normal) const {
  double least = HUGE_VAL, most = -HUGE_VAL;
  if (hit.cell >= 0) {
    mesh::CellVertices cell;
    mesh::gather(sampler_.mesh(), hit.cell, cell);
    for (int v = 0; v < cell.count; ++v) {
      const double height = dot(cell.x[v] - position, normal);
      least = std::min(least, height);
      most = std::max(most, height);
    }
  }
  const double largest =
      std::max({std::fabs(position.x), std::fabs(position.y), std::fabs(position.z)});
  return std::max(clearance_of_thickness * (most > least ? most - least : 0.0),
                  clearance_of_coordinates * largest);
}

} // namespace insitu::render
