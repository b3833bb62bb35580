#pragma once

#include "render/surface/isosurface.h"
#include "render/surface/tiles/active_cell.h"
#include "render/surface/tiles/cell_slabs.h"

namespace insitu::render {

/// Finds the hits of rays with isosurfaces, up to eight pairs of a ray and a cell at a time: each
/// is a patch with the ray as its only pixel (render/surface/tiles/patches.h), in the ray's own
/// space. A cell's slabs (CellSlabs), which a thread keeps from ray to ray, tell most pairs without
/// a patch. Where a proof is wanting the search by the ray (CellRoots, exact) takes the cell.
class RayCells {
public:
  static constexpr int most = RayLanes::most, most_pairs = Patches::most;
  using Search = IsosurfaceTracer::Search;

  /// Pairs that wait before they are searched: more share the work, fewer let a near hit end the
  /// ray. ended(ray) is told when a ray's t_max has changed.
  RayCells(const IsosurfaceTracer& surfaces, int enough, core::FunctionRef<void(int)> ended);

  /// Takes a ray, number 0 and so on; its search, whose hits and t_max this changes, and its start,
  /// if it starts on a surface, must outlive this.
  void add_ray(Search& search, const SecondaryStart* start);
  /// Takes a cell for these rays, a bit each, and searches those that wait once there are enough.
  void add(std::int64_t flat, unsigned rays);
  /// Searches all cells that wait.
  void flush();

private:
  using Level = IsosurfaceTracer::Level;
  using Group = IsosurfaceTracer::Group;
  struct Waiting {
    std::int64_t cell = 0;
    const Group* group = nullptr;
    const Level* level = nullptr;
    double extent = 0;
    int ray = 0;
  };
  /// Those of one domain.
  struct Batch {
    Patches patches;
    Waiting waiting[Patches::most];
  };
  struct CellHits;
  class Slabs;
  void put(std::int64_t flat, const Group& group, const Level& level, int ray);
  void solve(Batch& batch);
  bool split_up(const Patches& patches, int p, int depth, CellHits& found) const;
  void keep(const Waiting& waiting, double t, const math::Vec3d& parametric);
  void search_by_ray(const Waiting& waiting);
  bool take(const SurfaceHit& hit, int ray);

  const IsosurfaceTracer& surfaces_;
  const int enough_;
  core::FunctionRef<void(int)> ended_;
  int count_ = 0;
  Search* searches_[most];
  const SecondaryStart* starts_[most];
  RayLanes lanes_;
  Batch batches_[3];
};

} // namespace insitu::render
