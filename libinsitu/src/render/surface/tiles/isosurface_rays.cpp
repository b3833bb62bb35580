#include "render/surface/tiles/isosurface_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace insitu::render {

using math::Vec3d;

/// The slabs of cells that a thread's rays have met last, a cell and group at a place.
class RayCells::Slabs {
public:
  const CellSlabs& of(const IsosurfaceTracer& surfaces, std::int64_t flat, std::size_t group) {
    if (tracer_ != surfaces.number()) {
      tracer_ = surfaces.number();
      entries_.assign(places, {});
    }
    const std::int64_t key = flat * std::int64_t(surfaces.groups().size()) + std::int64_t(group);
    Entry& entry = entries_[(std::uint64_t(key) * 0x9e3779b97f4a7c15u) >> (64 - place_bits)];
    if (entry.key != key) {
      entry.key = key;
      entry.slabs = slabs_of(surfaces, flat, group);
    }
    return entry.slabs;
  }

private:
  static constexpr int place_bits = 12, places = 1 << place_bits;
  struct Entry {
    std::int64_t key = -1;
    CellSlabs slabs;
  };

  static CellSlabs slabs_of(const IsosurfaceTracer& surfaces, std::int64_t flat,
                            std::size_t group) {
    const mesh::MeshView& mesh = surfaces.sampler().mesh();
    const CellSource source(mesh, flat);
    double values[8];
    Vec3d x[8];
    if (!surfaces.groups()[group].load(source.piece, source.local, source.ids, source.count,
                                       values))
      return {}; // its range is empty: no level is in it
    source.points(mesh, x);
    return {source.shape, source.count, x, values};
  }

  std::uint64_t tracer_ = 0;
  std::vector<Entry> entries_;
};

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

RayCells::RayCells(const IsosurfaceTracer& surfaces, int enough, core::FunctionRef<void(int)> ended)
    : surfaces_(surfaces), enough_(enough), ended_(ended) {
  for (int i = 0; i < 3; ++i)
    batches_[i].patches.domain = PatchDomain(i);
}

void RayCells::add_ray(Search& search, const SecondaryStart* start) {
  const int i = count_++;
  searches_[i] = &search;
  starts_[i] = start;
  const Ray& ray = search.space.ray();
  for (int a = 0; a < 3; ++a) {
    lanes_.origin[a][i] = ray.origin[a];
    lanes_.direction[a][i] = float(ray.direction[a]);
  }
  lanes_.t_max[i] = accel::float_above(search.t_max);
}

void RayCells::add(std::int64_t flat, unsigned rays) {
  thread_local Slabs kept; // for the thread's life
  ++searches_[std::countr_zero(rays)]->counts.cells_tested;
  for (std::size_t g = 0; g < surfaces_.groups().size(); ++g) {
    const Group& group = surfaces_.groups()[g];
    const CellSlabs& slabs = kept.of(surfaces_, flat, g);
    for (const Level& level : group.levels) {
      if (!(slabs.low < level.value && level.value <= slabs.high))
        continue;
      for (unsigned left = slabs.may_meet(lanes_, rays, level.value); left; left &= left - 1) {
        const int ray = std::countr_zero(left);
        const SecondaryStart* const start = starts_[ray];
        if (start && start->cell == flat && start->surface == level.surface &&
            slabs.leaves(start->normal, start->clearance, searches_[ray]->space.ray().direction))
          continue;
        put(flat, group, level, ray);
      }
    }
  }
}

void RayCells::flush() {
  for (Batch& batch : batches_)
    if (batch.patches.count > 0)
      solve(batch);
}

void RayCells::put(std::int64_t flat, const Group& group, const Level& level, int ray) {
  const mesh::MeshView& mesh = surfaces_.sampler().mesh();
  const CellSource source(mesh, flat);
  Search& search = *searches_[ray];
  Vec3d x[8], corner[8];
  double values[8], f[8];
  source.points(mesh, x);
  double reach = 0; // across the ray: what a pixel's slack is measured by
  for (int v = 0; v < source.count; ++v) {
    x[v] = search.space(x[v]);
    values[v] = group.field.load(source.piece, source.ids[v]);
  }
  to_corners(source.shape, x, corner);
  to_corners(source.shape, values, f);
  Vec3d low = corner[0], high = corner[0];
  for (const Vec3d& c : corner) {
    reach = std::max({reach, std::fabs(c.x), std::fabs(c.y)});
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], c[a]);
      high[a] = std::max(high[a], c[a]);
    }
  }
  if (low.x > 0 || high.x < 0 || low.y > 0 || high.y < 0 || low.z > search.t_max ||
      high.z < search.t_min)
    return; // beside the ray
  const double scale = reach > 0 ? 1 / reach : 1;
  Batch& batch = batches_[int(domain_of(source.shape))];
  Patches& patches = batch.patches;
  const int at = patches.count++;
  for (int c = 0; c < 8; ++c) {
    patches.x[c][at] = scale * corner[c].x;
    patches.y[c][at] = scale * corner[c].y;
    patches.z[c][at] = corner[c].z;
    patches.f[c][at] = f[c] - level.value;
  }
  for (auto& lower : patches.lower)
    lower[at] = 0;
  const Vec3d size = high - low;
  batch.waiting[at] = {flat, &group, &level, std::sqrt(dot(size, size)), ray};
  if (patches.count >= enough_)
    solve(batch);
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
    } else if (searches_[waiting.ray]->t_max < 0) {
      continue; // the ray has ended since
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
  if (t >= searches_[waiting.ray]->t_min)
    take(IsosurfaceTracer::hit_of(root, waiting.extent, waiting.cell, *waiting.level), waiting.ray);
}

void RayCells::search_by_ray(const Waiting& waiting) {
  const Search& search = *searches_[waiting.ray];
  surfaces_.search_by_ray(
      waiting.cell, *waiting.group, *waiting.level, search.space, search.t_min, search.t_max,
      [&](const SurfaceHit& hit) { return take(hit, waiting.ray); }, search.counts);
}

/// Keeps a hit; whether the ray goes on.
bool RayCells::take(const SurfaceHit& hit, int ray) {
  Search& search = *searches_[ray];
  const double before = search.t_max;
  const bool goes_on = IsosurfaceTracer::keep(hit, search);
  if (search.t_max < before) {
    lanes_.t_max[ray] = accel::float_above(search.t_max);
    ended_(ray);
  }
  return goes_on;
}

} // namespace insitu::render
