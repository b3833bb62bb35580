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
  thread_local std::vector<SurfaceHit> hits[RayCells::most]; // kept for the thread's life
  for (std::size_t first = 0; first < rays.size(); first += RayCells::most) {
    const std::span<LightRay> packet =
        rays.subspan(first, std::min<std::size_t>(RayCells::most, rays.size() - first));
    collect(packet, hits, counts);
    for (std::size_t i = 0; i < packet.size(); ++i) {
      put_in_order(hits[i]);
      packet[i].open = open_past(hits[i]);
    }
  }
}

void IsosurfaceTracer::collect(std::span<const LightRay> rays, std::vector<SurfaceHit>* hits,
                               SurfaceCounts& counts) const {
  if (is_exact_)
    return collect_packet(rays, hits, counts);
  for (std::size_t i = 0; i < rays.size(); ++i)
    collect(rays[i].ray, hits[i], counts, rays[i].stays);
}

void IsosurfaceTracer::collect_packet(std::span<const LightRay> rays, std::vector<SurfaceHit>* hits,
                                      SurfaceCounts& counts) const {
  std::optional<Search> searches[RayCells::most];
  const accel::Tree& tree = sampler_.tree();
  const Vec3d low = tree.bounds_min() - tree.origin(), high = tree.bounds_max() - tree.origin();
  double largest = 0;
  for (int a = 0; a < 3; ++a)
    largest = std::max({largest, std::fabs(low[a]), std::fabs(high[a])});
  accel::RayPacket packet(tree.origin(), float(largest));
  const auto ended = [&](int i) { packet.end_at(i, searches[i]->t_max); };
  RayCells cells(*this, RayCells::most_pairs, ended);
  int count = 0;
  for (const LightRay& ray : rays) {
    std::vector<SurfaceHit>& found = *hits++;
    found.clear();
    if (ray.stays->empty())
      continue;
    const int i = count++;
    searches[i].emplace(search_of(ray.ray, ray.stays, found, counts));
    searches[i]->any = true;
    packet.set(i, ray.ray.origin, ray.ray.direction, searches[i]->t_max);
    cells.add_ray(*searches[i], ray.start);
  }
  accel::for_each_cell_along_packet(
      tree, packet, [&](std::uint32_t node) { return needed(node); },
      [&](std::int64_t item, unsigned of) {
        const mesh::MeshView& mesh = sampler_.mesh();
        const mesh::PieceView& piece = mesh.pieces[mesh.piece_of(item)];
        if (piece.is_halo)
          return; // its process finds its hits
        if (!piece.gridlets) {
          cells.add(item, of);
          return;
        }
        for (; of; of &= of - 1) {
          const int i = std::countr_zero(of);
          for_each_cell(item, *searches[i], [&](std::int64_t flat) { cells.add(flat, 1u << i); });
        }
      });
  cells.flush();
}

} // namespace insitu::render
