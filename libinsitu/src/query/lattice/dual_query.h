#pragma once

#include "query/lattice/dual_places.h"
#include "query/lattice/frustum_query.h"
#include "query/lattice/gridlet_query.h"

namespace insitu::query {

/// Finds the cells of an adaptive mesh's dual by their places: in gridlets, and stitching cells
/// that are frusta.
class DualFinder {
public:
  /// hint: a cell that is tried first, or -1.
  explicit DualFinder(const DualPlaces& at, std::int64_t hint = -1)
      : places_(at.gridlets), lattice_(&places_->gridlets().lattice),
        gridlets_(*places_, hint < places_->cell_count() ? hint : -1, at.shown),
        frusta_(*at.corners, *lattice_, places_->cell_count(), at.shown,
                places_->gridlets().count) {}

  static constexpr bool finds_all = false;

  /// Whether one of these owns p, and then which (at: left alone otherwise), or none where it is
  /// not shown; if not, any cell may, and then guess: a likely one, or left alone. What it answers
  /// does not depend on the points before.
  bool find(const math::Vec3d& p, Location& at, Reason& reason, std::int64_t& guess) {
    if (gridlets_.find_in_last(p, at, reason))
      return in_gridlet_ = true;
    if (in_gridlet_ && take_beside_last(p) && gridlets_.find_in_last(p, at, reason))
      return true;
    in_gridlet_ = false;
    return find_by_place(p, at, reason, guess);
  }

  /// find() of a batch's points from the q-th on, as long as they lie in its gridlet and others
  /// beside; returns the next.
  std::size_t find_ahead(std::span<const math::Vec3d> points, std::size_t q, BatchAnswers& to) {
    while (in_gridlet_ && points.size() - q >= 4) {
      q = gridlets_.find_ahead(points, q, to);
      in_gridlet_ = q == points.size() || take_beside_last(points[q]);
    }
    return q;
  }

private:
  /// The gridlet of the last one's depth that has p, most likely.
  bool take_beside_last(const math::Vec3d& p) {
    std::int64_t lower[3];
    const int depth = gridlets_.last_depth();
    return find_index(p, depth, 0.5, lower) && gridlets_.take_at(depth, lower);
  }

  bool find_by_place(const math::Vec3d& p, Location& at, Reason& reason, std::int64_t& guess) {
    const int leaf = leaf_depth(p);
    if (leaf < 0)
      return false;
    for (int depth = leaf; depth <= leaf + amr::CornerKind::most_up; ++depth) {
      if (depth > leaf && !frusta_.has_frusta(depth, depth - leaf))
        continue;
      // A cell's lower leaf and its corner tell its gridlet and its frustum alike.
      std::int64_t lower[3];
      if (!find_index(p, depth, 0.5, lower))
        return false;
      const std::int64_t corner[3] = {lower[0] + 1, lower[1] + 1, lower[2] + 1};
      if (depth == leaf && gridlets_.take_at(depth, lower) && gridlets_.find_in_last(p, at, reason))
        return in_gridlet_ = true;
      if (depth > leaf && frusta_.find_within(p, depth, depth - leaf, at, reason, guess))
        return true;
      // Where a cell stands, no finer leaf touches the corner, so none of theirs hold p.
      if (const amr::CornerMap::Found cell = frusta_.cell_at(depth, corner))
        return frusta_.find_at(p, depth, corner, cell, at, reason, guess);
    }
    return false;
  }

  /// Of the cell of a depth that holds p, moved down by `below` cells along each axis. False for
  /// points that are far from all cells, or no numbers.
  bool find_index(const math::Vec3d& p, int depth, double below, std::int64_t* index) const {
    const GridletPlaces::Steps& steps = places_->steps(depth);
    for (int a = 0; a < 3; ++a) {
      const double place = (p[a] - lattice_->origin[a]) * steps.a_unit[a] - below;
      if (!(std::fabs(place) < double(mesh::Lattice::largest_index)))
        return false;
      index[a] = std::int64_t(place);
      index[a] -= place < double(index[a]);
    }
    return true;
  }

  /// Of the leaf that holds p, about; -1 where there is none.
  int leaf_depth(const math::Vec3d& p) {
    int way = 0; // to finer depths, or to coarser ones
    for (int depth = last_depth_; depth >= 0 && depth < places_->depth_count(); depth += way) {
      std::int64_t index[3];
      if (!find_index(p, depth, 0.0, index))
        return -1;
      const int next = places_->way_to_leaf(depth, index);
      if (next == 0)
        return last_depth_ = depth; // most neighbours have the same
      if (next == -way)
        return -1;
      way = next;
    }
    return -1;
  }

  const GridletPlaces* places_;
  const mesh::Lattice* lattice_;
  GridletFinder gridlets_;
  FrustumFinder frusta_;
  int last_depth_ = 0;      ///< of a leaf
  bool in_gridlet_ = false; ///< the last point is
};

} // namespace insitu::query
