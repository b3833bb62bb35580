/// A committed mesh that becomes a copy of another one, apart from the solver.
#include <algorithm>

#include "commit/committed_mesh.h"

namespace insitu::commit {

void CommittedMesh::begin_copy(const CommittedMesh& of) {
  copied_ = &of;
  reference_frame = of.reference_frame;
  seam_tolerance = of.seam_tolerance;
  lent_fields_named_in = of.lent_fields_named_in;
  mesh_.set_is_part(of.mesh_.adaptive().is_part);
  locators_.choose(of.locators_.choice());
  policy_ = of.policy_;
  sides_ = of.sides_;
  rank_ = of.rank_;
}

void CommittedMesh::end_copy() {
  told_ = copied_->told_versions();
  copied_ = nullptr;
  policy_.set_builder(tree_.builder());
}

/// The other mesh's cells have the same flat ids, and its halo, if there is one, the same cells.
bool CommittedMesh::has_cells_of(const CommittedMesh& other) const {
  const mesh::MeshView &here = mesh_.view(), &there = other.mesh_.view();
  const mesh::MeshView &own = mesh_.own_view(), &others = other.mesh_.own_view();
  if (here.piece_count != there.piece_count || own.cell_count() != others.cell_count() ||
      own.own_cell_count() != others.own_cell_count() ||
      !std::equal(here.first_cell, here.first_cell + here.piece_count + 1, there.first_cell))
    return false;
  for (std::int64_t flat = own.own_cell_count(); flat < own.cell_count(); ++flat)
    if (!(name(flat) == other.name(flat)))
      return false;
  return true;
}

/// Returns false where the other mesh has none for these cells, or nobody has asked for it yet.
bool CommittedMesh::take_tree(const core::Threads& threads) {
  const TreeFit& fit = copied_->fit_;
  if (fit.lacks_tree() || copied_->lies_on_device() || !has_cells_of(*copied_))
    return false;
  tree_.copy(copied_->tree_);
  fit_.forget();
  if (fit.is_due())
    fit_.put_off(threads.count());
  if (is_made())
    tree_.mark_odd(mesh_.view(), odd_cells_.ids, threads);
  else
    set_odd_cells(std::move(odd_cells_), threads);
  commits_since_build_ = 0;
  return true;
}

/// A stand-in that is new; null: there is none.
void CommittedMesh::take_chart(const std::unique_ptr<StandIn>& fresh) {
  if (fresh && copied_ && copied_->stand_in_)
    fresh->take_chart(*copied_->stand_in_, mesh_.adaptive().is_part);
}

} // namespace insitu::commit
