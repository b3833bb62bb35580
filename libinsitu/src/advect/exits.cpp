#include "advect/exits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cells/kernels/kernels.h"
#include "mesh/box.h"
#include "mesh/ghosts.h"
#include "query/chart_image.h"
#include "query/walk/ahead.h"
#include "query/walk/face_crossing.h"

namespace insitu::advect {

/// What holds a place among the cells that no cell of the tracer's does; INSITU_END_LEFT: nothing.
insitu_ending Exits::of_place(const Vec3d& image, double alpha) {
  const query::LocateOptions options{accuracy_, alpha, false};
  if (whole_.among_images().locate(image, -1, options))
    return INSITU_END_BLANK;
  if (!asked_)
    made_ = left_out_();
  asked_ = true;
  if (!made_ || made_->count() == 0)
    return INSITU_END_LEFT;
  const query::Location at = made_->of(whole_.among_images()).locate(image, -1, options);
  if (!at)
    return INSITU_END_LEFT;
  const mesh::MeshView& mesh = whole_.mesh();
  const std::int32_t piece = mesh.piece_of(at.cell);
  return mesh::is_duplicate(mesh.pieces[piece], at.cell - mesh.first_cell[piece])
             ? INSITU_END_PARTITION
             : INSITU_END_HIDDEN;
}

insitu_ending Exits::ending(const query::Sampler& inside, const Beyond& beyond) {
  if (!beyond.open)
    return INSITU_END_LEFT;
  if (beyond.way == Vec3d{})
    return of_place(beyond.x, beyond.alpha);
  return query::meets_cells_ahead(inside.among_images(), beyond.x, beyond.way, beyond.alpha)
             ? INSITU_END_HOLE
             : INSITU_END_LEFT;
}

insitu_ending Exits::stronger(insitu_ending a, insitu_ending b) {
  for (const insitu_ending ending :
       {INSITU_END_BLANK, INSITU_END_HIDDEN, INSITU_END_PARTITION, INSITU_END_HOLE})
    if (a == ending || b == ending)
      return ending;
  return a;
}

insitu_ending Exits::ending(const query::Sampler& inside, const LeftAt& left, Beyond* open) {
  const auto leave_open = [&](const Vec3d& at, const Vec3d& way) {
    if (open)
      *open = {true, at, way, left.alpha};
  };
  const Vec3d x = inside.chart() ? (*inside.chart())(left.x) : left.x;
  if (!(std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z)))
    return left.seeded ? INSITU_END_SEED_OUTSIDE : INSITU_END_LEFT;
  if (left.seeded) {
    const insitu_ending there = of_place(x, left.alpha);
    leave_open(x, {});
    return there == INSITU_END_LEFT ? INSITU_END_SEED_OUTSIDE : there;
  }
  const query::Sampler cells = inside.among_images();
  // Where the cells have gone from it: what is there instead.
  if (left.cell < 0 || left.cell >= cells.mesh().cell_count()) {
    leave_open(x, {});
    return of_place(x, left.alpha);
  }
  mesh::CellVertices cell;
  mesh::gather(cells.mesh(), left.cell, cell, left.alpha);
  const mesh::Box box = mesh::box_of(cell);
  const auto unit = [](const Vec3d& v) {
    const double length = std::sqrt(dot(v, v));
    return length > 0.0 && std::isfinite(length) ? v / length : Vec3d{};
  };
  // The face that it left through, if that is known; else the nearest one, and away from the cell.
  const auto map = cells::inverse_map(cell.shape, cell.x, x);
  const Vec3d ways[] = {unit(left.normal), query::nearest_face(cell, left.cell, map.r).normal,
                        unit(x - box.middle())};
  const double size = std::sqrt(dot(box.size(), box.size()));
  const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * std::sqrt(dot(x, x));
  for (const Vec3d& way : ways) {
    if (way == Vec3d{})
      continue;
    bool goes_on = false;
    Vec3d beyond = x;
    for (const double part : {1e-9, 1e-6, 1e-3}) { // of the cell, so that thin gaps are looked over
      beyond = x + std::max(part * size, rounding) * way;
      if ((goes_on = bool(cells.locate(beyond, left.cell, {accuracy_, left.alpha, false}))))
        break;
      if (const insitu_ending there = of_place(beyond, left.alpha); there != INSITU_END_LEFT)
        return there;
    }
    if (!goes_on) {
      leave_open(beyond, way);
      return query::meets_cells_ahead(cells, beyond, way, left.alpha) ? INSITU_END_HOLE
                                                                      : INSITU_END_LEFT;
    }
  }
  return INSITU_END_LEFT;
}

} // namespace insitu::advect
