#pragma once

#include "render/surface/isosurface.h"
#include "render/surface/tiles/active_cell.h"

namespace insitu::render {

/// Finds the hits of one ray with isosurfaces, up to eight cells at a time: each is a patch with
/// the ray as its only pixel (render/surface/tiles/patches.h), in the ray's own space. Where a
/// proof is wanting the search by the ray (CellRoots, exact) takes the cell.
class RayCells {
public:
  /// The search, whose hits and t_max this changes, must outlive it.
  RayCells(const IsosurfaceTracer& surfaces, IsosurfaceTracer::Search& search)
      : surfaces_(surfaces), search_(search) {
    for (int i = 0; i < 3; ++i)
      batches_[i].patches.domain = PatchDomain(i);
  }

  /// Takes a cell, and searches those that wait once there are enough.
  void add(std::int64_t flat);
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
  };
  /// Those of one domain.
  struct Batch {
    Patches patches;
    Waiting waiting[Patches::most];
  };
  struct CellHits;
  void put(const ActiveCell& cell, const Level& level, Batch& batch) const;
  void solve(Batch& batch);
  bool split_up(const Patches& patches, int p, int depth, CellHits& found) const;
  void keep(const Waiting& waiting, double t, const math::Vec3d& parametric);
  void search_by_ray(const Waiting& waiting);

  const IsosurfaceTracer& surfaces_;
  IsosurfaceTracer::Search& search_;
  Batch batches_[3];
};

} // namespace insitu::render
