#pragma once

#include <cstdint>

#include "advect/field/cell_cache.h"
#include "advect/field/confinement.h"
#include "advect/field/mesh_boundary.h"
#include "advect/field/moment.h"

namespace insitu::advect {

/// What a ChartVelocity has besides: see there.
struct KeptChart {
  std::int64_t sized = -1;
  math::Vec3d extent;
  math::Vec3d known_x, known_image, anchor_x, anchor_image;
  std::int8_t pole = 0;
  bool confined = false;
};

/// What a MeshVelocity's answers depend on between two steps of a particle, in plain data. Cells
/// are flat ids, or -1.
struct KeptVelocity {
  Moment::Kept moment;
  CellCache::Kept cells;
  Confinement confined;
  MeshBoundary boundary;
  PlaceInCell place;
  std::int64_t hint, cell, sized;
  math::Vec3d extent;
  KeptChart chart = {};

  /// f(id) of each id of a cell.
  template <class F>
  void for_each_cell(F&& f) {
    for (std::int64_t* id : {&cells.cells[0], &cells.cells[1], &cells.own, &place.cell, &hint,
                             &cell, &sized, &chart.sized})
      f(*id);
  }
};

} // namespace insitu::advect
