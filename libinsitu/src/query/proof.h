#pragma once

#include "accel/tree/odd_slots.h"
#include "cells/kernels/kernels.h"
#include "query/location.h"
#include "query/lone_cells.h"

/// The one rule that says when a proof answers for a point, and the one trial of a cell. A proof is
/// a certificate of Newton's method that a cell holds the point in its interior.
namespace insitu::query {

/// Whether a proven cell answers alone. In a mesh whose cells do not fold no other cell can own a
/// point in a cell's interior, unless cells overlap. Where a few cells fold, and the tree knows
/// which (accel::OddSlots), the same holds for points that none of these cells may hold; their
/// boxes are those of the current coordinates.
class ProofRule {
public:
  /// odd: what the tree marks. lone: which cells are alone, as far as it is known; or null. The
  /// arguments must outlive the object.
  ProofRule(const mesh::MeshView& mesh, const accel::OddSlots& odd, const LocateOptions& options,
            const LoneCells* lone = nullptr)
      : odd_(&odd), lone_(lone), for_all_(mesh.free_of_folds),
        for_some_(mesh.free_of_folds || (!odd.empty() && options.alpha == 1.0)),
        is_enough_(options.accuracy != INSITU_EXACT || mesh.covers_once) {}

  /// Whether proofs count for some points at all, or for every point.
  bool for_some() const { return for_some_; }
  bool for_all() const { return for_all_; }
  /// Whether a proof counts for this point.
  bool counts_for(const math::Vec3d& p) const {
    return for_all_ || (for_some_ && !odd_->may_hold(p));
  }
  /// A cell so proven is the answer, whichever it is; else cells of lower ids are looked at as
  /// well, since cells may overlap and `exact` names the lowest, but for cells that are alone.
  bool is_enough() const { return is_enough_; }
  bool is_enough(std::int64_t cell) const { return is_enough_ || (lone_ && lone_->has(cell)); }
  /// Whether it is so for some cells at all.
  bool may_be_enough() const { return is_enough_ || lone_; }

private:
  const accel::OddSlots* odd_;
  const LoneCells* lone_;
  bool for_all_, for_some_, is_enough_;
};

/// The proof that a cell holds p, or an empty location. vertices: the cell's, of some coordinates.
inline Location try_cell(const mesh::CellVertices& vertices, std::int64_t cell,
                         const math::Vec3d& p) {
  const auto map = cells::inverse_map(vertices.shape, vertices.x, p);
  return map.margin > map.error ? Location{cell, map.r} : Location{};
}

} // namespace insitu::query
