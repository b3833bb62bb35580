#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "accel/camera_rays/packet_traversal.h"
#include "render/surface/isosurface.h"
#include "render/surface/tiles/isosurface_rays.h"

namespace insitu::render {

using math::Vec3d;

void IsosurfaceTracer::trace(std::span<LightRay> rays, SurfaceCounts& counts) const {
  if (!is_exact_) {
    thread_local std::vector<SurfaceHit> hits; // kept for the thread's life
    for (LightRay& ray : rays) {
      trace(ray.ray, hits, counts, ray.stays);
      ray.open = open_past(hits);
    }
    return;
  }
  for (std::size_t first = 0; first < rays.size(); first += RayCells::most)
    trace_packet(rays.subspan(first, std::min<std::size_t>(RayCells::most, rays.size() - first)),
                 counts);
}

void IsosurfaceTracer::trace_packet(std::span<LightRay> rays, SurfaceCounts& counts) const {
  thread_local std::vector<SurfaceHit> hits[RayCells::most]; // kept for the thread's life
  std::optional<Search> searches[RayCells::most];
  const accel::Tree& tree = sampler_.tree();
  const Vec3d low = tree.bounds_min() - tree.origin(), high = tree.bounds_max() - tree.origin();
  double largest = 0;
  for (int a = 0; a < 3; ++a)
    largest = std::max({largest, std::fabs(low[a]), std::fabs(high[a])});
  accel::RayPacket packet(tree.origin(), float(largest));
  const auto ended = [&](int i) { packet.end_at(i, searches[i]->t_max); };
  RayCells cells(*this, RayCells::most_pairs, ended);
  LightRay* traced[RayCells::most];
  int count = 0;
  for (LightRay& ray : rays) {
    ray.open = 1;
    if (ray.stays->empty())
      continue;
    const int i = count++;
    traced[i] = &ray;
    hits[i].clear();
    searches[i].emplace(search_of(ray.ray, ray.stays, hits[i], counts));
    searches[i]->any = true;
    packet.set(i, ray.ray.origin, ray.ray.direction, searches[i]->t_max);
    cells.add_ray(*searches[i], ray.start);
  }
  accel::for_each_cell_along_packet(
      tree, packet, [&](std::uint32_t node) { return needed(node); },
      [&](std::int64_t item, unsigned of) {
        const mesh::MeshView& mesh = sampler_.mesh();
        if (!mesh.pieces[mesh.piece_of(item)].gridlets) {
          cells.add(item, of);
          return;
        }
        for (; of; of &= of - 1) {
          const int i = std::countr_zero(of);
          for_each_cell(item, *searches[i], [&](std::int64_t flat) { cells.add(flat, 1u << i); });
        }
      });
  cells.flush();
  LastCell none;
  for (int i = 0; i < count; ++i) {
    for (SurfaceHit& hit : hits[i])
      hit.gradient = {}; // nothing is lit here
    settle(hits[i], none);
    traced[i]->open = open_past(hits[i]);
  }
}

} // namespace insitu::render
