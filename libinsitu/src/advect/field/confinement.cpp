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
  const double crossed = cells_crossed(towards, extent);
  return crossed > 0.0 && std::isfinite(crossed) ? (cells / crossed) * towards : Vec3d{};
}

/// The faces of a cell, a bit each, on which x lies and along which it goes.
unsigned faces_along(const KeptCell& cell, const Moment& moment, const Vec3d& x,
                     const Vec3d& towards) {
  constexpr double way = 1e-3, slope = 1e-7; // in cells
  const mesh::CellVertices& c = cell.vertices;
  const Vec3d on = x + part_of_cell(towards, cell.extent(moment), way);
  const auto here = cells::inverse_map(c.shape, c.x, x),
             there = cells::inverse_map(c.shape, c.x, on);
  if (!here.converged || !there.converged)
    return 0;
  double n[8], m[8];
  cells::shape_functions(c.shape, here.r, n);
  cells::shape_functions(c.shape, there.r, m);
  unsigned faces = 0;
  for (int f = 0; f < cells::face_table(c.shape).face_count; ++f) {
    const double from = cells::parametric_distance(c.shape, f, n);
    const double change = cells::parametric_distance(c.shape, f, m) - from;
    if (std::abs(from) <= control::on_face && std::abs(change) <= way * slope)
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
                        const Vec3d& towards, std::int64_t hint) {
  is_on_ = false;
  along_ = 0;
  query::Location at = moment.locate(x, hint);
  if (!at || !cells.can_keep(at.cell))
    return false;
  KeptCell* own = &cells.take_own(at.cell, moment);
  if (depth(*own, x) < 1e-9) { // on a face: of the cells there, the one that is entered
    at = moment.locate(x + part_of_cell(towards, own->extent(moment), little_way), at.cell);
    if (at && at.cell != own->cell && cells.can_keep(at.cell))
      own = &cells.take_own(at.cell, moment);
    along_ = faces_along(*own, moment, x, towards);
  }
  return is_on_ = true;
}

double Confinement::depth(const KeptCell& own, const Vec3d& x) {
  const auto map = cells::inverse_map(own.vertices.shape, own.vertices.x, x);
  r_ = map.r;
  return map.converged ? depth_at(own, map.r, map.margin) : -1.0;
}

/// The least distance from a face but for those the particle goes along, unless it is this far
/// beyond one of these.
double Confinement::depth_beside(mesh::Shape shape, const Vec3d& r) const {
  double n[8], depth = std::numeric_limits<double>::infinity();
  cells::shape_functions(shape, r, n);
  for (int f = 0; f < cells::face_table(shape).face_count; ++f) {
    const double d = cells::parametric_distance(shape, f, n);
    if ((along_ >> f & 1U) == 0)
      depth = std::min(depth, d);
    else if (d < -beyond_along)
      depth = std::min(depth, d + beyond_along);
  }
  return depth;
}

Vec3d Confinement::on_faces(const KeptCell& own, const Vec3d& x, const Vec3d& r, double error) {
  const mesh::CellVertices& c = own.vertices;
  return cells::is_near_faces(c.shape, r, control::on_face)
             ? cells::put_on_faces_of(c.shape, c.x, x,
                                      cells::put_on_nearest(c.shape, c.x, x, r, error),
                                      control::on_face)
             : r;
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
  towards_ = towards;
  return x + part_of_cell(towards, cells.own(moment).extent(moment), little_way);
}

query::Location Confinement::locate(CellCache& cells, const Moment& moment, const Vec3d& x) const {
  if (const std::int64_t cell = cells.across(r_, x); cell >= 0) {
    KeptCell& k = cells.beside(cell, moment);
    k.move_to(moment);
    if (const query::Location at = query::try_cell(k.vertices, cell, x)) {
      cells.count_proven();
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
  along_ =
      is_on_face(own.vertices.shape, at.parametric) ? faces_along(own, moment, x, towards_) : 0;
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
      const query::Location out =
          moment.locate(face.point + part_of_cell(face.normal, extent, part), own.cell);
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
