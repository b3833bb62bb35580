#include "advect/field/mesh_velocity.h"

namespace insitu::advect {

using math::Vec3d;

void MeshVelocity::begin(std::int64_t hint) {
  const std::int64_t cells = sampler().mesh().cell_count();
  hint_ = hint < cells ? hint : -1; // the mesh may have become smaller
  cell_ = sized_ = -1;
  place_.cell = -1;
  confined_.release();
  cells_.begin();
}

Sampled MeshVelocity::in_own_cell(const Vec3d& x, Vec3d& v, query::Location* where) {
  const KeptCell& own = cells_.own(moment_);
  const auto map = cells::inverse_map(own.vertices.shape, own.vertices.x, x);
  if (!confined_.found(own, map.converged, map.r, map.margin))
    return Sampled::outside;
  note_place(x, own, map.r, map.margin, map.error);
  const Vec3d r = Confinement::on_faces(own, x, map.r, map.error, cells_.takes_boundaries());
  if (where)
    *where = {own.cell, r};
  return own.interpolate(r, moment_, v);
}

/// By the sampler: the point is in no cell that is kept, or cannot be proven to be.
Sampled MeshVelocity::located(const Vec3d& x, Vec3d& v, query::Location* where) {
  cells_.note_unguided(cells_.last());
  query::Location at = moment_.locate(x, cells_.serves() ? -1 : hint_);
  if (!at)
    at = beside_mesh(x);
  if (where)
    *where = at;
  return taken(at, v);
}

/// The velocity at a place that was located, whose cell is kept.
Sampled MeshVelocity::taken(const query::Location& at, Vec3d& v) {
  place_.cell = -1;
  if (!at)
    return Sampled::outside;
  hint_ = at.cell;
  if (cells_.serves() && cells_.can_keep(at.cell))
    return cells_.keep(at.cell, moment_).interpolate(at.parametric, moment_, v);
  return moment_.interpolate(at, v);
}

/// Whether the cell that answered last tells that x, of that point or the same to rounding, is in
/// the mesh.
bool MeshVelocity::is_kept_in_mesh(const Vec3d& x) {
  if (!cells_.takes_boundaries() || place_.cell < 0)
    return false;
  KeptCell& k = confined_.is_on() ? cells_.own(moment_) : cells_.last(moment_);
  if (k.cell != place_.cell)
    return false;
  if (!place_.is_of(x, moment_)) {
    const auto map = cells::inverse_map(k.vertices.shape, k.vertices.x, x);
    note_place(x, k, map.r, map.margin, map.error);
  }
  const Held how = cells_.held(k, moment_, place_.margin, place_.error);
  if (how == Held::on_boundary)
    return cells_.closes(k, moment_, place_.r, place_.error);
  return how == Held::inside || (confined_.is_on() && cells_.near_own(x, moment_));
}

/// Whether x, in no cell that is kept, lies beside the one that answered last, by rounding, at a
/// face across which no cell is known: boundary_.inside() then stands for it.
bool MeshVelocity::is_beside_kept(const Vec3d& x) {
  if (!cells_.takes_boundaries() || place_.cell < 0 || !place_.is_of(x, moment_))
    return false;
  KeptCell& k = confined_.is_on() ? cells_.own(moment_) : cells_.last(moment_);
  return k.cell == place_.cell && cells::is_on_boundary(place_.margin, place_.error) &&
         boundary_.beside_cell(moment_, x, k);
}

Vec3d MeshVelocity::kept_inside(const Vec3d& x) {
  if (boundary_.stands_for(x, moment_))
    return boundary_.inside();
  const bool is_free = !confined_.is_on();
  const bool may_be_beyond =
      is_free ? cells_.takes_boundaries() && place_.is_of(x, moment_) && !place_.is_inside()
              : confined_.may_be_beyond();
  if (!may_be_beyond || is_kept_in_mesh(x) || cells_.hold(x, moment_))
    return x;
  if (moment_.locate(x, is_free ? hint_ : cells_.own().cell))
    return x;
  if (is_beside_kept(x))
    return boundary_.inside();
  return beside_mesh(x, is_free ? 0.0 : confined_.reach(cells_.own(), moment_)) ? boundary_.inside()
                                                                                : x;
}

bool MeshVelocity::stays_in_own(const Vec3d& x, double t) {
  if (!cells_.takes_boundaries() || !confined_.is_on())
    return false;
  moment_.set(t);
  KeptCell& own = cells_.own(moment_);
  if (!place_.is_of(x, moment_) || place_.cell != own.cell) {
    const auto map = cells::inverse_map(own.vertices.shape, own.vertices.x, x);
    note_place(x, own, map.r, map.margin, map.error);
  }
  if (cells_.held(own, moment_, place_.margin, place_.error) == Held::no)
    return false;
  cell_ = hint_ = own.cell;
  return true;
}

Vec3d MeshVelocity::kept_inside(const Vec3d& x, double t) {
  const Vec3d y = kept_inside(x);
  if (geometry_alpha(t) == moment_.geometry_alpha())
    return y;
  moment_.set(t);
  if (is_kept_in_mesh(y) || (cells_.takes_boundaries() && cells_.hold(y, moment_)))
    return y;
  if (moment_.locate(y, cell_))
    return y;
  return is_beside_kept(y) || beside_mesh(y) ? boundary_.inside() : y;
}

Vec3d MeshVelocity::extent() {
  if (sized_ != cell_) {
    sized_ = cell_;
    for (const KeptCell* k : {&cells_.own(), &cells_.last()})
      if (k->cell == cell_ && (!moment_.moves() || k->alpha == moment_.alpha()))
        return extent_ = k->extent(moment_);
    mesh::CellVertices c;
    mesh::gather(sampler().mesh(), cell_, c, moment_.geometry_alpha());
    extent_ = edges_of(box_of(c));
  }
  return extent_;
}

Crossed MeshVelocity::crossed(const Vec3d& x, const query::Location& at) {
  const Crossed crossed = confined_.cross(cells_, moment_, x, at);
  if (crossed == Crossed::into_next)
    hint_ = cells_.own().cell;
  return crossed;
}

std::optional<query::Exit> MeshVelocity::leave(const Vec3d& a, const Vec3d& b, double t,
                                               double dt) {
  auto exit = boundary_.leave(moment_, cell_, a, b, t, dt);
  if (exit)
    cell_ = hint_ = exit->owner;
  return exit;
}

double MeshVelocity::way_out(const Vec3d& a, const Vec3d& b, double t) {
  moment_.set(t);
  return boundary_.way_out(moment_, cell_, extent(), a, b);
}

} // namespace insitu::advect
