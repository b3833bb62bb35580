#pragma once

#include <cmath>
#include <string>

#include "render/surface/tiles/isosurface_tile.h"
#include "unit/render/placed_mesh.h"

/// Isosurfaces cell by cell in tiles of the screen beside the search by the ray.
namespace insitu::test {

using render::Camera;
using render::IsosurfaceSettings;
using render::IsosurfaceTile;
using render::IsosurfaceTracer;
using render::SurfaceHit;

inline double sphere(const Vec3d& p) {
  const Vec3d d = p - Vec3d{0.5, 0.5, 0.5};
  return std::sqrt(dot(d, d)) +
         0.012 * std::sin(23 * p.x) * std::sin(19 * p.y) * std::sin(21 * p.z);
}

inline double gyroid(const Vec3d& p) {
  const double k = 2 * M_PI * 2;
  return std::sin(k * p.x) * std::cos(k * p.y) + std::sin(k * p.y) * std::cos(k * p.z) +
         std::sin(k * p.z) * std::cos(k * p.x);
}

/// The rays for which tiles and rays differ, told in words.
struct Compared {
  std::int64_t rays = 0, hits = 0, other = 0;
  double worst = 0; ///< difference of depths, of the extent in the cell
  std::string first;
};

/// Whether a hit lies on the ray and on its surface, by its own cell's map.
inline bool is_root(const query::Sampler& sampler, const std::vector<IsosurfaceSettings>& settings,
                    const render::Ray& ray, const SurfaceHit& hit) {
  mesh::CellVertices cell;
  mesh::gather(sampler.mesh(), hit.cell, cell);
  const Vec3d p = cells::map_to_physical(cell.shape, cell.x, hit.parametric);
  const Vec3d off = p - (ray.origin + hit.t * ray.direction);
  const double level = settings[0].values[std::size_t(hit.surface)];
  const double value = settings[0].field.at(sampler.mesh(), {hit.cell, hit.parametric});
  return std::sqrt(dot(off, off)) < 1e-8 * hit.extent && std::fabs(value - level) < 1e-8;
}

/// Compares a frame's hits.
inline Compared compare(const query::Sampler& sampler,
                        const std::vector<IsosurfaceSettings>& settings,
                        render::Structures& structures, const Camera& camera, int width, int height,
                        const std::vector<render::Clip>& clips = {}) {
  const IsosurfaceTracer tracer(sampler, settings, structures);
  const render::RayGenerator rays(camera, width, height);
  IsosurfaceTile tile;
  Compared result;
  std::vector<SurfaceHit> together, alone;
  std::vector<render::Stretch> stays;
  render::SurfaceCounts counts;
  for (int y0 = 0; y0 < height; y0 += IsosurfaceTile::side)
    for (int x0 = 0; x0 < width; x0 += IsosurfaceTile::side) {
      const int x1 = std::min(width, x0 + IsosurfaceTile::side);
      const int y1 = std::min(height, y0 + IsosurfaceTile::side);
      tile.trace(tracer, rays, clips, x0, y0, x1, y1, counts);
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          together.clear();
          tile.hits(x, y, together);
          const render::Ray ray = rays(x, y);
          render::clip_ray(clips, ray, 0, HUGE_VAL, stays);
          tracer.trace(ray, alone, counts, clips.empty() ? nullptr : &stays);
          ++result.rays;
          result.hits += std::int64_t(alone.size());
          bool same = together.size() == alone.size();
          // Where a cell folds, the search by the ray can take a place for a root that is none.
          for (std::size_t i = 0; same && i < alone.size(); ++i) {
            const double off = std::fabs(together[i].t - alone[i].t) /
                               std::max(alone[i].extent, together[i].extent);
            same = together[i].surface == alone[i].surface &&
                   (off < 1e-6 || (is_root(sampler, settings, ray, together[i]) &&
                                   !is_root(sampler, settings, ray, alone[i])));
            if (same && off < 1e-6)
              result.worst = std::max(result.worst, off);
          }
          if (same)
            continue;
          if (result.other++ == 0) {
            result.first = "pixel " + std::to_string(x) + ", " + std::to_string(y) + ":";
            for (const auto* list : {&together, &alone}) {
              result.first += list == &together ? " tile" : " ray";
              for (const SurfaceHit& hit : *list)
                result.first +=
                    " t " + std::to_string(hit.t) + " cell " + std::to_string(hit.cell) + " at " +
                    std::to_string(hit.parametric.x) + " " + std::to_string(hit.parametric.y) +
                    " " + std::to_string(hit.parametric.z) + " surface " +
                    std::to_string(hit.surface) + ";";
            }
          }
        }
    }
  return result;
}

inline std::vector<double> at_vertices(const TestMesh& mesh, double (*of)(const Vec3d&)) {
  std::vector<double> values;
  for (const Vec3d& p : mesh.vertices)
    values.push_back(of(p));
  return values;
}

struct View {
  const char* name;
  Camera camera;
};

inline std::vector<View> views() {
  Camera far = Camera::around({0, 0, 0}, {1, 1, 1}, 40, 25);
  Camera straight = Camera::around({0, 0, 0}, {1, 1, 1}, 0, 0);
  Camera inside;
  inside.position = {0.52, 0.47, 0.55};
  inside.look_at = {0.9, 0.6, 0.2};
  inside.up = {0, 0, 1};
  inside.fov = 100;
  Camera flat = far;
  flat.orthographic_height = 1.8;
  Camera flat_straight = straight;
  flat_straight.orthographic_height = 1.0;
  Camera near = far;
  near.position = near.look_at + 0.35 * (near.position - near.look_at) / 2.0;
  near.fov = 60;
  return {{"far", far},           {"straight", straight},        {"inside", inside},
          {"orthographic", flat}, {"along axes", flat_straight}, {"near", near}};
}

} // namespace insitu::test
