#include "render/surface/tiles/isosurface_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace insitu::render {

using math::Vec3d;

namespace {

/// Cells that wait before they are searched: more share the work, fewer let a near hit end the ray.
constexpr int enough = 4;

} // namespace

/// What is found of a cell and level.
struct RayCells::CellHits {
  int count = 0;
  double t[16];
  Vec3d parametric[16];

  /// Takes a hit; false if there are too many.
  bool add(const PatchRoots& roots, int p) {
    if (count == 16)
      return false;
    t[count] = roots.depth[p];
    parametric[count++] = {roots.parametric[0][p], roots.parametric[1][p], roots.parametric[2][p]};
    return true;
  }
};

void RayCells::add(std::int64_t flat) {
  ++search_.counts.cells_tested;
  for_each_active(surfaces_, flat, search_.space, [&](const ActiveCell& cell) {
    Batch& batch = batches_[int(cell.domain)];
    for (const Level& level : cell.group->levels) {
      if (cell.holds(level))
        put(cell, level, batch);
      if (batch.patches.count >= enough)
        solve(batch);
    }
  });
}

void RayCells::flush() {
  for (Batch& batch : batches_)
    if (batch.patches.count > 0)
      solve(batch);
}

void RayCells::put(const ActiveCell& cell, const Level& level, Batch& batch) const {
  double reach = 0; // across the ray: what a pixel's slack is measured by
  Vec3d low = cell.corner[0], high = cell.corner[0];
  for (const Vec3d& c : cell.corner) {
    reach = std::max({reach, std::fabs(c.x), std::fabs(c.y)});
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], c[a]);
      high[a] = std::max(high[a], c[a]);
    }
  }
  if (low.x > 0 || high.x < 0 || low.y > 0 || high.y < 0 || low.z > search_.t_max ||
      high.z < search_.t_min)
    return; // beside the ray
  const double scale = reach > 0 ? 1 / reach : 1;
  Patches& patches = batch.patches;
  const int at = patches.count++;
  cell.put(patches, at);
  for (int c = 0; c < 8; ++c) {
    patches.x[c][at] *= scale;
    patches.y[c][at] *= scale;
    patches.f[c][at] -= level.value;
  }
  const Vec3d size = high - low;
  batch.waiting[at] = {cell.flat, cell.group, &level, std::sqrt(dot(size, size))};
}

void RayCells::solve(Batch& batch) {
  Patches& patches = batch.patches;
  PatchSetup setup;
  set_up(patches, ray_tile(), true, setup);
  const PatchRoots roots = solve_rays(patches, setup);
  const int count = patches.count;
  for (int p = 0; p < count; ++p) {
    const Waiting& waiting = batch.waiting[p];
    if (roots.hit >> p & 1) {
      keep(waiting, roots.depth[p],
           {roots.parametric[0][p], roots.parametric[1][p], roots.parametric[2][p]});
    } else if (roots.unsure >> p & 1) {
      search_by_ray(waiting);
    } else if (roots.unproven >> p & 1) {
      CellHits found;
      if (split_up(patches, p, 0, found))
        for (int i = 0; i < found.count; ++i)
          keep(waiting, found.t[i], found.parametric[i]);
      else
        search_by_ray(waiting);
    }
  }
  patches.count = 0;
}

/// Whether the parts of a patch can all be told.
bool RayCells::split_up(const Patches& patches, int p, int depth, CellHits& found) const {
  if (depth == most_splits)
    return false;
  Patches parts;
  PatchSetup setup;
  split(patches, p, parts);
  set_up(parts, ray_tile(), true, setup);
  const PatchRoots roots = solve_rays(parts, setup);
  for (int k = 0; k < parts.count; ++k) {
    if (!is_in_domain(parts, k))
      continue;
    if (roots.unsure >> k & 1)
      return false;
    if ((roots.hit >> k & 1) && !found.add(roots, k))
      return false;
    if ((roots.unproven >> k & 1) && !split_up(parts, k, depth + 1, found))
      return false;
  }
  return true;
}

void RayCells::keep(const Waiting& waiting, double t, const Vec3d& parametric) {
  LevelHit root;
  root.t = t;
  root.parametric = parametric;
  root.gradient.x = std::numeric_limits<double>::quiet_NaN(); // found when the hit is known to stay
  if (t >= search_.t_min)
    IsosurfaceTracer::keep(
        IsosurfaceTracer::hit_of(root, waiting.extent, waiting.cell, *waiting.level), search_);
}

void RayCells::search_by_ray(const Waiting& waiting) {
  surfaces_.search_by_ray(
      waiting.cell, *waiting.group, *waiting.level, search_.space, search_.t_min, search_.t_max,
      [&](const SurfaceHit& hit) { return IsosurfaceTracer::keep(hit, search_); }, search_.counts);
}

} // namespace insitu::render
