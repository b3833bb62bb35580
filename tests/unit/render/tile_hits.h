#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "accel/camera_rays/ray_traversal.h"
#include "core/random.h"
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

/// Whether a hit lies on the ray and on its surface, by its own cell's map.
inline bool is_root(const IsosurfaceTracer& tracer, const render::Ray& ray, const SurfaceHit& hit) {
  const mesh::MeshView& mesh = tracer.sampler().mesh();
  mesh::CellVertices cell;
  mesh::gather(mesh, hit.cell, cell);
  const Vec3d p = cells::map_to_physical(cell.shape, cell.x, hit.parametric);
  const Vec3d off = p - (ray.origin + hit.t * ray.direction);
  for (const IsosurfaceTracer::Group& group : tracer.groups())
    for (const IsosurfaceTracer::Level& level : group.levels)
      if (level.surface == hit.surface) {
        const double value = group.field.at(mesh, {hit.cell, hit.parametric});
        return std::sqrt(dot(off, off)) < 1e-8 * hit.extent &&
               std::fabs(value - level.value) < 1e-8 * (1 + std::fabs(level.value));
      }
  return false;
}

/// Where other searches differ from that in one cell after the other.
struct Compared {
  std::int64_t rays = 0, hits = 0, other = 0;
  double worst = 0;  ///< difference of depths, of the extent in the cell
  std::string first; ///< what differs, in words

  void compare(const IsosurfaceTracer& tracer, const render::Ray& ray,
               const std::vector<SurfaceHit>& right, const std::vector<SurfaceHit>& found,
               const char* name, int x, int y) {
    bool same = found.size() == right.size();
    for (std::size_t i = 0; same && i < right.size(); ++i) {
      const double off =
          std::fabs(found[i].t - right[i].t) / std::max(right[i].extent, found[i].extent);
      // Where a cell folds, its inverse map jumps from one sheet to the other, and that search can
      // take the jump for a root that is none, near to one or not.
      const bool is_better =
          off > 1e-10 && is_root(tracer, ray, found[i]) && !is_root(tracer, ray, right[i]);
      same = found[i].surface == right[i].surface && (off < 1e-6 || is_better);
      if (same && !is_better)
        worst = std::max(worst, off);
    }
    if (same || other++ > 0)
      return;
    first = "pixel " + std::to_string(x) + ", " + std::to_string(y) + ":";
    for (const auto* list : {&found, &right}) {
      first += list == &right ? " cell by cell" : std::string(" ") + name;
      for (const SurfaceHit& hit : *list)
        first += " t " + std::to_string(hit.t) + " cell " + std::to_string(hit.cell) + " at " +
                 std::to_string(hit.parametric.x) + " " + std::to_string(hit.parametric.y) + " " +
                 std::to_string(hit.parametric.z) + " surface " + std::to_string(hit.surface) + ";";
    }
  }
};

/// The hits of a ray by the search in one cell after the other.
inline void trace_cell_by_cell(const IsosurfaceTracer& tracer, const render::Ray& ray,
                               const std::vector<render::Stretch>* stays,
                               std::vector<SurfaceHit>& hits) {
  hits.clear();
  if (stays && stays->empty())
    return;
  const mesh::MeshView& mesh = tracer.sampler().mesh();
  render::SurfaceCounts counts;
  IsosurfaceTracer::Search search{cells::RaySpace(ray),
                                  stays,
                                  stays ? stays->front().from : 0.0,
                                  stays ? std::min(stays->back().to, 1e300) : 1e300,
                                  hits,
                                  counts};
  const auto test = [&](std::int64_t flat) {
    mesh::CellVertices cell;
    mesh::gather(mesh, flat, cell);
    render::CellRoots roots(cell, search.space, search.t_min, search.t_max);
    if (!roots.meets())
      return;
    const std::int64_t local = flat - mesh.first_cell[cell.piece];
    for (const IsosurfaceTracer::Group& group : tracer.groups()) {
      double values[8];
      if (group.load(cell.piece, local, cell.ids, cell.count, values))
        for (const IsosurfaceTracer::Level& level : group.levels)
          roots.find(
              values, level.value,
              [&](const render::LevelHit& root) {
                return IsosurfaceTracer::keep(
                    IsosurfaceTracer::hit_of(root, roots.extent(), flat, level), search);
              },
              render::RootSearch::exact);
    }
  };
  accel::for_each_cell_along_ray(
      tracer.sampler().tree(), ray.origin, ray.direction, search.t_min, search.t_max,
      [&](std::uint32_t node) { return tracer.needed(node); },
      [&](std::int64_t flat) {
        const mesh::PieceView& piece = mesh.pieces[mesh.piece_of(flat)];
        for (std::int64_t c = flat; c < flat + piece.cells_an_item(); ++c)
          if (piece.owns(c - mesh.first_cell[mesh.piece_of(flat)]))
            test(c);
        return search.t_max;
      });
  IsosurfaceTracer::LastCell none;
  tracer.settle(hits, none);
}

/// Compares the hits of a frame's rays: of tiles, and of rays one by one.
inline Compared compare(const query::Sampler& sampler,
                        const std::vector<IsosurfaceSettings>& settings,
                        render::Structures& structures, const Camera& camera, int width, int height,
                        const std::vector<render::Clip>& clips = {}) {
  const IsosurfaceTracer tracer(sampler, settings, structures);
  const render::RayGenerator rays(camera, width, height);
  IsosurfaceTile tile;
  Compared result;
  std::vector<SurfaceHit> together, alone, right;
  std::vector<render::Stretch> stays;
  render::SurfaceCounts counts;
  for (int y0 = 0; y0 < height; y0 += IsosurfaceTile::side)
    for (int x0 = 0; x0 < width; x0 += IsosurfaceTile::side) {
      const int x1 = std::min(width, x0 + IsosurfaceTile::side);
      const int y1 = std::min(height, y0 + IsosurfaceTile::side);
      tile.trace(tracer, rays, clips, x0, y0, x1, y1, counts);
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          const render::Ray ray = rays(x, y);
          render::clip_ray(clips, ray, 0, HUGE_VAL, stays);
          const auto* const left = clips.empty() ? nullptr : &stays;
          together.clear();
          tile.hits(x, y, together);
          tracer.trace(ray, alone, counts, left);
          trace_cell_by_cell(tracer, ray, left, right);
          ++result.rays;
          result.hits += std::int64_t(right.size());
          result.compare(tracer, ray, right, together, "tile", x, y);
          result.compare(tracer, ray, right, alone, "ray", x, y);
        }
    }
  return result;
}

/// What hits let through, if hits of one surface that lie nearer than a billionth of a cell's reach
/// along the ray are one, as packets have it. The search in one cell knows the ray's own way
/// through the cell alone, which may be much shorter: in flat cells two crossings beside a face may
/// be 1e-6 of that way apart.
inline double open_by_reach(const IsosurfaceTracer& tracer, const render::Ray& ray,
                            std::vector<SurfaceHit> hits) {
  for (SurfaceHit& hit : hits) {
    mesh::CellVertices cell;
    mesh::gather(tracer.sampler().mesh(), hit.cell, cell);
    double reach = 0;
    for (int a = 0; a < 3; ++a) {
      double low = cell.x[0][a], high = low;
      for (int v = 1; v < cell.count; ++v) {
        low = std::min(low, cell.x[v][a]);
        high = std::max(high, cell.x[v][a]);
      }
      reach += std::fabs(ray.direction[a]) * (high - low);
    }
    hit.extent = std::max(hit.extent, reach);
  }
  IsosurfaceTracer::LastCell none;
  tracer.settle(hits, none);
  return render::open_past(hits);
}

/// Rays of light from what a camera sees of surfaces, in packets, beside the search in one cell
/// after the other.
inline Compared compare_light(const query::Sampler& sampler,
                              const std::vector<IsosurfaceSettings>& settings,
                              render::Structures& structures, const Camera& camera, int size,
                              const std::vector<render::Clip>& clips = {}) {
  const IsosurfaceTracer tracer(sampler, settings, structures);
  const render::RayGenerator cameras(camera, size, size);
  constexpr int directions = 3; // of each hit; packets are of several hits
  std::vector<SurfaceHit> hits, right;
  std::vector<render::SecondaryStart> starts;
  std::vector<render::LightRay> rays;
  std::vector<std::vector<render::Stretch>> stays;
  render::SurfaceCounts counts;
  Compared result;
  for (int pixel = 0; pixel < size * size; ++pixel) {
    const render::Ray seen = cameras(pixel % size, pixel / size);
    tracer.trace(seen, hits, counts);
    for (const SurfaceHit& hit : hits) {
      const Vec3d position = seen.origin + hit.t * seen.direction;
      // Scaled first: gradients may be as small as their field's values.
      const double largest = std::max(
          {std::fabs(hit.gradient.x), std::fabs(hit.gradient.y), std::fabs(hit.gradient.z)});
      if (!(largest > 0 && std::isfinite(largest)))
        continue;
      const Vec3d g = hit.gradient / largest;
      const Vec3d up = g / std::copysign(std::sqrt(dot(g, g)), -dot(g, seen.direction));
      const double clearance = 1e-5 * hit.extent;
      for (int k = 0; k < directions; ++k) {
        Vec3d d;
        for (int a = 0; a < 3; ++a)
          d[a] = 2 * core::random_unit(7, rays.size(), std::uint64_t(a)) - 1;
        d = d / std::sqrt(dot(d, d));
        if (dot(d, up) < 0)
          d = -d;
        starts.push_back({hit.cell, hit.surface, up, clearance});
        rays.push_back({{position + clearance * up, d}});
        stays.emplace_back();
        render::clip_ray(clips, rays.back().ray, 0, k % 2 == 0 ? HUGE_VAL : 0.2, stays.back());
      }
    }
  }
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i].stays = &stays[i];
    rays[i].start = i % 7 == 3 ? nullptr : &starts[i];
  }
  tracer.trace(std::span(rays), counts);
  for (const render::LightRay& ray : rays) {
    trace_cell_by_cell(tracer, ray.ray, ray.stays, right);
    ++result.rays;
    result.hits += !right.empty();
    const bool same =
        ray.open == render::open_past(right) || ray.open == open_by_reach(tracer, ray.ray, right) ||
        // Where a cell folds, that search can take a place for a root that is none.
        std::any_of(right.begin(), right.end(),
                    [&](const SurfaceHit& hit) { return !is_root(tracer, ray.ray, hit); });
    if (same || result.other++ > 0)
      continue;
    const auto at = std::to_string(&ray - rays.data());
    result.first = "ray " + at + " lets through " + std::to_string(ray.open) + " and not " +
                   std::to_string(render::open_past(right));
    if (!right.empty())
      result.first += ", t " + std::to_string(right[0].t) + " cell " +
                      std::to_string(right[0].cell) + " from cell " +
                      std::to_string(starts[std::size_t(&ray - rays.data())].cell);
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
