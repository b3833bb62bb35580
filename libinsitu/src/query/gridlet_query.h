#pragma once

#include <cmath>
#include <cstdint>

#include "cells/decide.h"
#include "mesh/view.h"
#include "query/sampler.h"

/// Points in gridlets: without a tree, and exactly, since the cells are boxes whose faces are
/// doubles.
namespace insitu::query {

/// The gridlets of a mesh that begins with a piece of them, or null. Their cells then have lower
/// ids than all others.
inline const mesh::GridletsView* gridlets_of(const mesh::MeshView& mesh) {
  return mesh.piece_count > 0 ? mesh.pieces[0].gridlets : nullptr;
}

/// The closed cell of a gridlet that holds p, the lowest if there are several; none if it is in no
/// full cell.
inline Location locate_in_gridlet(const mesh::GridletsView& all, std::int64_t gridlet,
                                  const math::Vec3d& p, Reason& reason) {
  const mesh::Gridlet& g = all.gridlets[gridlet];
  const std::int64_t first = gridlet << mesh::Gridlet::cell_bits;
  int lowest[3], choices[3], faces = 0;
  double from[3][2], to[3][2]; // of the one or two cells along each axis
  for (int a = 0; a < 3; ++a) {
    const double start = all.coordinate(g, a, 0);
    const int last = g.size[a] - 1;
    const double steps = (p[a] - start) / all.lattice.width(a, g.depth);
    int i = steps > 0.0 ? (steps < last ? int(steps) : last) : 0; // 0 for NaN
    double low = all.coordinate(g, a, i), high = all.coordinate(g, a, i + 1);
    if (p[a] < low && i > 0) { // the division rounds
      high = low;
      low = all.coordinate(g, a, --i);
    } else if (p[a] > high && i < last) {
      low = high;
      high = all.coordinate(g, a, ++i + 1);
    }
    if (!(low <= p[a] && p[a] <= high))
      return {};
    lowest[a] = i;
    choices[a] = 1;
    from[a][0] = low;
    to[a][0] = high;
    if (p[a] != low && p[a] != high)
      continue;
    ++faces;
    if (p[a] == low && i > 0) {
      lowest[a] = i - 1;
      choices[a] = 2;
      from[a][1] = low;
      to[a][1] = high;
      from[a][0] = all.coordinate(g, a, i - 1);
      to[a][0] = low;
    } else if (p[a] == high && i < last) {
      choices[a] = 2;
      from[a][1] = high;
      to[a][1] = all.coordinate(g, a, i + 2);
    }
  }
  for (int k = 0; k < choices[2]; ++k)
    for (int j = 0; j < choices[1]; ++j)
      for (int i = 0; i < choices[0]; ++i) {
        const std::int64_t cell = first + lowest[0] + i + 8 * (lowest[1] + j + 8 * (lowest[2] + k));
        if (!all.is_full(cell))
          continue;
        constexpr Reason why[] = {Reason::certified, Reason::on_face, Reason::on_edge,
                                  Reason::on_vertex};
        reason = why[faces];
        const int at[3] = {i, j, k};
        Location found{cell, {}};
        for (int a = 0; a < 3; ++a)
          found.parametric[a] = (p[a] - from[a][at[a]]) / (to[a][at[a]] - from[a][at[a]]);
        return found;
      }
  return {};
}

/// Finds gridlets by their places. Remembers the last one, since neighbours mostly lie in one
/// (Zellmann 2023, section 5.2).
class GridletFinder {
public:
  /// hint: a cell whose gridlet is tried first, or -1.
  explicit GridletFinder(const mesh::GridletsView& all, std::int64_t hint = -1)
      : all_(&all), last_(hint < 0 ? -1 : hint >> mesh::Gridlet::cell_bits) {}

  /// The cell of a gridlet that holds p strictly inside; or none, and then it may be in any cell.
  Location operator()(const math::Vec3d& p) {
    if (const Location at = inside(last_, p))
      return at;
    for (int d = 0; d < all_->depth_count; ++d) {
      std::int64_t lower[3];
      bool near = true;
      for (int a = 0; a < 3; ++a) {
        const double steps =
            (p[a] - all_->lattice.origin[a]) / all_->lattice.width(a, all_->depths[d]) - 0.5;
        near &= std::fabs(steps) < double(mesh::Lattice::largest_index);
        lower[a] = near ? std::int64_t(std::floor(steps)) : 0;
      }
      const std::int64_t found = near ? all_->find(all_->depths[d], lower) : -1;
      if (found < 0 || found == last_)
        continue;
      if (const Location at = inside(found, p)) {
        last_ = found;
        return at;
      }
    }
    return {};
  }

private:
  /// Almost all points of a gridlet's box, and none else.
  Location inside(std::int64_t gridlet, const math::Vec3d& p) const {
    if (gridlet < 0)
      return {};
    const mesh::Gridlet& g = all_->gridlets[gridlet];
    Location found{gridlet << mesh::Gridlet::cell_bits, {}};
    for (int a = 0, shift = 0; a < 3; ++a, shift += 3) {
      const double start = all_->coordinate(g, a, 0);
      const double steps = (p[a] - start) / all_->lattice.width(a, g.depth);
      if (!(steps > 0.0 && steps < g.size[a]))
        return {};
      const int i = int(steps);
      const double low = all_->coordinate(g, a, i), high = all_->coordinate(g, a, i + 1);
      if (!(low < p[a] && p[a] < high))
        return {};
      found.cell += std::int64_t(i) << shift;
      found.parametric[a] = (p[a] - low) / (high - low);
    }
    return all_->is_full(found.cell) ? found : Location{};
  }

  const mesh::GridletsView* all_;
  std::int64_t last_;
};

} // namespace insitu::query
