#pragma once

#include "query/adaptive.h"
#include "query/frustum_query.h"
#include "query/gridlet_query.h"

namespace insitu::query {

/// Finds the cells of an adaptive mesh's dual by their places: in gridlets, and stitching cells
/// that are frusta.
class DualFinder {
public:
  /// adaptive: not `nearest`. hint: a cell that is tried first, or -1. shown: a bit a gridlet, and
  /// then a bit a stitching cell, whether they may answer; null: all.
  explicit DualFinder(const Adaptive& adaptive, std::int64_t hint = -1,
                      const std::uint64_t* shown = nullptr)
      : DualFinder(*adaptive.gridlets(), *adaptive.corners(), hint, shown) {}

  static constexpr bool finds_all = false;

  /// Whether one of these owns p, and then which (at: left alone otherwise), or none where it is
  /// not shown; if not, any cell may, and then guess: a likely one, or left alone. What it answers
  /// does not depend on the points before.
  bool find(const math::Vec3d& p, Location& at, Reason& reason, std::int64_t& guess) {
    return gridlets_.find_in_last(p, at, reason) || find_by_place(p, at, reason, guess);
  }

private:
  DualFinder(const GridletPlaces& places, const amr::CornerMap& corners, std::int64_t hint,
             const std::uint64_t* shown)
      : places_(&places), lattice_(&places.gridlets().lattice),
        gridlets_(places, hint < places.cell_count() ? hint : -1, shown),
        frusta_(corners, *lattice_, places.cell_count(), shown, places.gridlets().count) {}

  bool find_by_place(const math::Vec3d& p, Location& at, Reason& reason, std::int64_t& guess) {
    // A cell's lower leaf and its corner tell its gridlet and its frustum alike.
    // Neighbours mostly have the same depth.
    const int last = last_depth_, depths = places_->depth_count();
    for (int d = depths > 0 ? -1 : 0; d < depths; ++d) {
      if (d == last)
        continue;
      const int depth = places_->depth(d < 0 ? last : d);
      const GridletPlaces::Steps& steps = places_->steps(depth);
      std::int64_t index[3], corner[3];
      bool near = true;
      for (int a = 0; a < 3; ++a) {
        const double place = (p[a] - lattice_->origin[a]) * steps.a_unit[a] - 0.5;
        near &= std::fabs(place) < double(2 * mesh::Lattice::largest_index);
        index[a] = near ? std::int64_t(place) : 0;
        index[a] -= place < double(index[a]);
        corner[a] = index[a] + 1;
      }
      if (!near)
        return false; // from all cells, or no number
      if (gridlets_.find_at(p, depth, index, at, reason) ||
          frusta_.find_at(p, depth, corner, at, reason, guess)) {
        last_depth_ = d < 0 ? last : d;
        return true;
      }
    }
    return frusta_.find_within(p, at, reason, guess);
  }

  const GridletPlaces* places_;
  const mesh::Lattice* lattice_;
  GridletFinder gridlets_;
  FrustumFinder frusta_;
  int last_depth_ = 0; ///< a number of GridletPlaces::depth
};

} // namespace insitu::query
