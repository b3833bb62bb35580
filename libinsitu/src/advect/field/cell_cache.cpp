#include "advect/field/cell_cache.h"

#include <utility>

#include "advect/field/owners.h"
#include "cells/exact/decide.h"
#include "cells/kernels/on_feature.h"

namespace insitu::advect {

using math::Vec3d;

CellCache::CellCache(const Moment& moment)
    : sampler_(&moment.sampler()), by_places_(sampler_->locator().dual() != nullptr),
      proof_(moment.mesh(), sampler_->odd(), {moment.accuracy(), moment.moves() ? 0.0 : 1.0}),
      sound_(sampler_->sound_cells(moment.moves())) {}

/// Cells in runs have no vertices of their own to keep. Those of another process's gridlets come
/// one by one, as the only voxels of a dual that stand so.
bool CellCache::can_keep(std::int64_t cell) const {
  const mesh::MeshView& mesh = sampler_->mesh();
  const std::int32_t p = mesh.piece_of(cell);
  const mesh::PieceView& piece = mesh.pieces[p];
  return !piece.in_runs() &&
         !(by_places_ && piece.shape(cell - mesh.first_cell[p]) == mesh::Shape::voxel);
}

/// A cell that may own points and has vertices to keep.
bool CellCache::may_own(std::int64_t cell) const {
  const mesh::MeshView& mesh = sampler_->mesh();
  const std::int32_t p = mesh.piece_of(cell);
  const mesh::PieceView& piece = mesh.pieces[p];
  const std::int64_t local = cell - mesh.first_cell[p];
  return !piece.in_runs() && piece.exists(local) && piece.shape(local) != mesh::Shape::none;
}

void CellCache::find_sound(KeptCell& k, const Moment& moment) const {
  k.sound = sound_->known(k.cell);
  if (k.sound != query::SoundCells::Known::unknown)
    return;
  const query::SoundCells::Asked asked[] = {{k.cell, k.current(moment), &k.sound}};
  sound_->find(sampler_->mesh().cell_count(), k.vertices.shape, asked);
}

/// The guess at a neighbour, or a cell across an edge or vertex; or -1.
std::int64_t CellCache::next_cell(const KeptCell& from, const Vec3d& r, double near) const {
  const std::int64_t cell = beyond_->guess(from.cell, from.vertices.shape, r, near);
  return cell >= 0 && cell < sampler_->mesh().cell_count() && may_own(cell) ? cell : -1;
}

void CellCache::open(KeptCell& k, std::int64_t cell, const Moment& moment) const {
  k.open(cell, moment);
  if (beyond_)
    beyond_->foresee(cell);
}

void CellCache::load(KeptCell& k, std::int64_t cell, const Moment& moment) const {
  if (k.opened != cell)
    open(k, cell, moment);
  k.load(moment);
}

void CellCache::go_on_from(const Kept& kept, const Moment& moment) {
  const auto take = [&](KeptCell& k, std::int64_t cell) {
    k.forget();
    if (cell >= 0)
      load(k, cell, moment);
  };
  for (int i = 0; i < 2; ++i)
    take(*kept_[i], kept.cells[i]);
  take(*own_, kept.own);
  last_ = kept.last;
}

const KeptCell& CellCache::keep(std::int64_t cell, const Moment& moment) {
  for (int i = 0; i < 2; ++i)
    if (kept_[i]->cell == cell) {
      last_ = i;
      return *kept_[i];
    }
  last_ ^= 1;
  load(*kept_[last_], cell, moment);
  return *kept_[last_];
}

KeptCell& CellCache::take_own(std::int64_t cell, const Moment& moment) {
  for (KeptCell*& k : kept_)
    if (k->cell == cell) {
      std::swap(k, own_);
      return own(moment);
    }
  load(*own_, cell, moment);
  return own(moment);
}

void CellCache::foresee(std::int64_t cell) const {
  const mesh::MeshView& mesh = sampler_->mesh();
  const std::int32_t p = mesh.piece_of(cell);
  const mesh::PieceView& piece = mesh.pieces[p];
  if (piece.layout == mesh::CellLayout::uniform || piece.layout == mesh::CellLayout::padded)
    __builtin_prefetch(piece.connectivity.data +
                       (cell - mesh.first_cell[p]) * piece.connectivity.stride);
}

query::Location CellCache::near_own(const Vec3d& x, const Moment& moment) {
  KeptCell& own = this->own(moment);
  const auto map = cells::inverse_map(own.vertices.shape, own.vertices.x, x);
  if (const Held how = held(own, moment, map.margin, map.error); how != Held::no) {
    count(how);
    return {own.cell, map.r};
  }
  const std::int64_t cell = beyond_ && map.converged ? next_cell(own, map.r, 0.0) : -1;
  if (cell < 0)
    return {};
  KeptCell& next = beside(cell, moment);
  next.move_to(moment);
  const auto there = cells::inverse_map(next.vertices.shape, next.vertices.x, x);
  const Held how = held(next, moment, there.margin, there.error);
  if (how == Held::no)
    return {};
  count(how);
  return {cell, there.r};
}

bool CellCache::closes(KeptCell& k, const Moment& moment, const Vec3d& r, double error) {
  const unsigned on = cells::vertices_near(k.vertices.shape, r, error);
  if (!beyond_ || on == 0)
    return false;
  if (k.closed_on != on && cells_about(moment.mesh(), *beyond_, k.cell, on).closed)
    k.closed_on = on;
  return k.closed_on == on;
}

bool CellCache::hold(const Vec3d& x, const Moment& moment) {
  for (KeptCell* k : {own_, kept_[0], kept_[1]})
    if (k->cell >= 0) {
      k->move_to(moment);
      if (cells::decide(k->vertices.shape, k->vertices.x, x))
        return true;
    }
  return false;
}

} // namespace insitu::advect
