#include "advect/field/confinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "advect/field/face_on_path.h"
#include "advect/integrate/control.h"
#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "cells/kernels/on_feature.h"
#include "query/walk/face_crossing.h"

namespace insitu::advect {

using math::Vec3d;

namespace {

/// So far beyond a face, in cells, that it goes along, a particle is still in its own cell.
constexpr double beyond_along = 10.0 * control::on_face;
/// So far on, in cells, a place tells which cell comes next.
constexpr double little_way = 1e-7;

/// A vector this way that crosses so much of a cell.
Vec3d part_of_cell(const Vec3d& towards, const Vec3d& extent, double cells) {
  const double crossed = cells_crossed(towards, extent), factor = cells / crossed;
  return std::isfinite(crossed) && std::isfinite(factor) ? factor * towards : Vec3d{};
}

/// The faces of a cell, a bit each, on which x lies and along which it goes. most: the way that it
/// may go, in cells.
unsigned faces_along(const KeptCell& cell, const Moment& moment, const Vec3d& x,
                     const Vec3d& towards, double most) {
  constexpr double way = 1e-3, slope = 1e-7; // in cells
  const mesh::CellVertices& c = cell.vertices;
  const Vec3d on = x + part_of_cell(towards, cell.extent(moment), way);
  const auto here = cells::inverse_map(c.shape, c.x, x);
  const auto there = on == x ? here : cells::inverse_map(c.shape, c.x, on);
  if (!here.converged || !there.converged)
    return 0;
  double n[8], m[8];
  cells::shape_functions(c.shape, here.r, n);
  cells::shape_functions(c.shape, there.r, m);
  unsigned faces = 0;
  for (int f = 0; f < cells::face_table(c.shape).face_count; ++f) {
    const double from = cells::parametric_distance(c.shape, f, n);
    const double change = cells::parametric_distance(c.shape, f, m) - from;
    if (std::abs(from) <= control::on_face &&
        (std::abs(change) <= way * slope || most * std::abs(change) <= way * control::on_face))
      faces |= 1U << f;
  }
  return faces;
}

/// Whether coordinates in a cell lie on one of its faces.
bool is_on_face(mesh::Shape shape, const Vec3d& r) {
  double n[8];
  cells::shape_functions(shape, r, n);
  for (int f = 0; f < cells::face_table(shape).face_count; ++f)
    if (std::abs(cells::parametric_distance(shape, f, n)) <= control::on_face)
      return true;
  return false;
}

} // namespace

bool Confinement::start(CellCache& cells, const Moment& moment, const Vec3d& x,
                        const Vec3d& towards, std::int64_t hint, const PlaceInCell& place) {
  is_on_ = false;
  along_ = 0;
  const bool is_known = place.is_of(x, moment);
  const std::int64_t cell = is_known ? place.cell : moment.locate(x, hint).cell;
  if (cell < 0 || !cells.can_keep(cell))
    return false;
  KeptCell* own = &cells.take_own(cell, moment);
  r_ = place.r;
  if ((is_known ? place.margin : depth(*own, x)) < 1e-9) { // of the cells at the face, the one
    const Vec3d way = way_in(cells, moment, towards);      // that is entered
    const Vec3d on = x + part_of_cell(way, own->extent(moment), little_way);
    if (const query::Location at =
            cells.takes_boundaries() ? beside_own(cells, moment, on) : moment.locate(on, cell);
        at && at.cell != cell && cells.can_keep(at.cell))
      own = &cells.take_own(at.cell, moment);
    along_ = faces_along(*own, moment, x, way, most_way(cells, moment, way));
  }
  is_answered_ = is_known && own->cell == cell && cells.takes_boundaries();
  if (is_answered_)
    (void)found(*own, true, place.r, place.margin);
  begin_step();
  return is_on_ = true;
}

Vec3d Confinement::way_in(const CellCache& cells, const Moment& moment,
                          const Vec3d& towards) const {
  if (!cells.takes_boundaries())
    return towards;
  // What is no way within the step is none, of whatever direction rounding has made it.
  constexpr double no_way = 0.1 * control::on_face; // in cells
  const KeptCell& own = cells.own();
  const double interval = std::abs(moment.times().interval());
  const Vec3d way = towards - own.moved(r_) / interval;
  return cells_crossed(interval * way, own.extent(moment)) <= no_way ? Vec3d{} : way;
}

/// The way that a particle may go until the step ends, in cells, if cells take boundaries.
double Confinement::most_way(const CellCache& cells, const Moment& moment, const Vec3d& way) {
  return cells.takes_boundaries()
             ? cells_crossed(std::abs(moment.times().interval()) * way, cells.own().extent(moment))
             : std::numeric_limits<double>::infinity();
}

/// The cell of a place near a particle in the own cell.
query::Location Confinement::beside_own(CellCache& cells, const Moment& moment, const Vec3d& x) {
  if (const query::Location at = cells.near_own(x, moment))
    return at;
  cells.note_unguided(cells.own());
  return moment.locate(x, cells.own().cell);
}

double Confinement::depth(const KeptCell& own, const Vec3d& x) {
  const auto map = cells::inverse_map(own.vertices.shape, own.vertices.x, x);
  r_ = map.r;
  return map.converged ? depth_at(own, map.r, map.margin) : -1.0;
}

/// The least distance from a face but for those the particle goes along, unless it is this far
/// beyond one of these.
double Confinement::depth_beside(mesh::Shape shape, const Vec3d& r) const {
  double distance[6], depth = std::numeric_limits<double>::infinity();
  const int faces = cells::parametric_distances(shape, r, distance);
  for (int f = 0; f < faces; ++f) {
    const double d = distance[f];
    if ((along_ >> f & 1U) == 0)
      depth = std::min(depth, d);
    else if (d < -beyond_along)
      depth = std::min(depth, d + beyond_along);
  }
  return depth;
}

Vec3d Confinement::on_faces(const KeptCell& own, const Vec3d& x, const Vec3d& r, double error,
                            bool moves) {
  const mesh::CellVertices& c = own.vertices;
  if (!cells::is_near_faces(c.shape, r, control::on_face))
    return r;
  const Vec3d put = cells::put_on_nearest(c.shape, c.x, x, r, error);
  return moves ? put : cells::put_on_faces_of(c.shape, c.x, x, put, control::on_face);
}

double Confinement::face_on(const KeptCell& own, const DenseStep& path, double low, double high) {
  const PlaceOnPath found = face_on_path(own.vertices, along_, path, low, high, r_);
  if (found.theta >= 0.0)
    r_ = found.r;
  return found.theta;
}

bool Confinement::is_inside_before(const KeptCell& own, const DenseStep& path) const {
  return advect::is_inside_before(own.vertices, along_, path, r_);
}

Vec3d Confinement::beyond(CellCache& cells, const Moment& moment, const Vec3d& x,
                          const Vec3d& towards) {
  const KeptCell& own = cells.own(moment);
  towards_ = way_in(cells, moment, towards);
  return x + part_of_cell(towards_, own.extent(moment), little_way);
}

query::Location Confinement::locate(CellCache& cells, const Moment& moment, const Vec3d& x) const {
  if (cells.takes_boundaries())
    return beside_own(cells, moment, x);
  if (const std::int64_t cell = cells.across(r_, x); cell >= 0) {
    KeptCell& k = cells.beside(cell, moment);
    k.move_to(moment);
    if (const query::Location at = query::try_cell(k.vertices, cell, x);
        at && cells.answers_alone(k, moment)) {
      cells.count(Held::inside);
      return at;
    }
  }
  cells.note_unguided(cells.own());
  return moment.locate(x, cells.own().cell);
}

/// The particle is at x, on a face, and goes on into the cell of a place beyond that face.
Crossed Confinement::enter(CellCache& cells, const Moment& moment, const Vec3d& x,
                           const query::Location& at) {
  landed_ = true;
  if (!at)
    return Crossed::to_boundary;
  if (!cells.can_keep(at.cell))
    return Crossed::nowhere;
  const KeptCell& own = cells.take_own(at.cell, moment);
  // It may still be on another face than that it came through.
  along_ = is_on_face(own.vertices.shape, at.parametric)
               ? faces_along(own, moment, x, towards_, most_way(cells, moment, towards_))
               : 0;
  return Crossed::into_next;
}

Crossed Confinement::cross(CellCache& cells, const Moment& moment, const Vec3d& x,
                           const query::Location& at) {
  const KeptCell& own = cells.own();
  if (!at || at.cell != own.cell)
    return enter(cells, moment, x, at);
  // Almost along the face, or a little short of it.
  const auto map = cells::inverse_map(own.vertices.shape, own.vertices.x, x);
  if (map.converged) {
    const query::FaceCrossing face = query::nearest_face(own.vertices, own.cell, map.r);
    const Vec3d extent = own.extent(moment);
    for (double part = 1e-8; part < 1e-4; part *= 10.0) {
      const Vec3d y = face.point + part_of_cell(face.normal, extent, part);
      const query::Location out =
          cells.takes_boundaries() ? beside_own(cells, moment, y) : moment.locate(y, own.cell);
      if (!out || out.cell != own.cell)
        return enter(cells, moment, x, out);
    }
  }
  return Crossed::nowhere;
}

bool Confinement::may_be_beyond() {
  const bool landed = std::exchange(landed_, false);
  return is_on_ && (along_ != 0 || landed || !(depth_ > control::on_face));
}

double Confinement::reach(const KeptCell& own, const Moment& moment) const {
  const Vec3d extent = own.extent(moment);
  const double cells = 2.0 * (along_ != 0 ? beyond_along : control::on_face);
  return cells * std::max({extent.x, extent.y, extent.z});
}

} // namespace insitu::advect
