#include "render/surface/surfaces_together.h"

#include <algorithm>
#include <cmath>

namespace insitu::render {

namespace {

/// Surfaces of two meshes that touch lie at one place but for rounding, so their order would change
/// from pixel to pixel: within this part of the distance the earlier mesh is in front.
constexpr double same_place = 1e-9;

/// Puts hits of a further mesh among those that are there; both end with the first opaque one.
void put_among(std::vector<SurfaceHit>& hits, const std::vector<SurfaceHit>& further,
               std::vector<SurfaceHit>& scratch) {
  scratch.clear();
  const auto add = [&](const SurfaceHit& hit) {
    if (scratch.empty() || scratch.back().opacity < 1)
      scratch.push_back(hit);
  };
  auto next = further.begin();
  for (const SurfaceHit& hit : hits) {
    for (; next != further.end() && next->t < hit.t - same_place * std::fabs(hit.t); ++next)
      add(*next);
    add(hit);
  }
  for (; next != further.end(); ++next)
    add(*next);
  hits.swap(scratch);
}

} // namespace

void put_hits_together(std::size_t layers, std::span<RayState> rays,
                       core::FunctionRef<void(std::size_t layer)> find) {
  thread_local std::vector<std::vector<SurfaceHit>> all; // these two for the thread's life
  thread_local std::vector<SurfaceHit> scratch;
  if (all.size() < rays.size())
    all.resize(rays.size());
  for (std::size_t r = 0; r < rays.size(); ++r)
    all[r].clear();
  for (std::size_t layer = 0; layer < layers; ++layer) {
    find(layer);
    for (std::size_t r = 0; r < rays.size(); ++r) {
      for (SurfaceHit& hit : rays[r].hits)
        hit.layer = std::int32_t(layer);
      put_among(all[r], rays[r].hits, scratch);
      rays[r].hits.clear();
    }
  }
  for (std::size_t r = 0; r < rays.size(); ++r)
    rays[r].hits.swap(all[r]);
}

void order_together(std::span<const Surfaces* const> surfaces, std::span<RayState> rays) {
  if (surfaces.size() == 1)
    return surfaces[0]->put_in_order(rays);
  thread_local std::vector<std::vector<SurfaceHit>> unordered; // for the thread's life
  if (unordered.size() < rays.size())
    unordered.resize(rays.size());
  for (std::size_t r = 0; r < rays.size(); ++r) {
    unordered[r].clear();
    unordered[r].swap(rays[r].hits);
  }
  put_hits_together(surfaces.size(), rays, [&](std::size_t l) {
    if (!surfaces[l])
      return;
    for (std::size_t r = 0; r < rays.size(); ++r)
      for (const SurfaceHit& hit : unordered[r])
        if (hit.layer == std::int32_t(l))
          rays[r].hits.push_back(hit);
    surfaces[l]->put_in_order(rays);
  });
}

void trace_together(std::span<const Surfaces* const> surfaces, std::span<RayState> rays,
                    std::span<IsosurfaceTile* const> tiles, SurfaceCounts& counts) {
  put_hits_together(surfaces.size(), rays, [&](std::size_t layer) {
    if (surfaces[layer])
      surfaces[layer]->find(rays, tiles[layer], counts);
  });
  for (const Surfaces* const of : surfaces)
    if (of)
      of->light(rays, counts);
  for (const Surfaces* const of : surfaces)
    if (of)
      of->add_lines(rays);
}

} // namespace insitu::render
