#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "cells/exact/decide.h"
#include "mesh/view.h"
#include "query/batch/batch_answers.h"
#include "query/lattice/gridlet_lanes.h"
#include "query/lattice/gridlet_places.h"
#include "query/location.h"

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

/// A gridlet's box; `least` and `most` keep off what rounding may put into a neighbour.
inline GridletBox box_of(const GridletPlaces& places, std::int64_t gridlet) {
  const mesh::GridletsView& all = places.gridlets();
  const mesh::Gridlet& g = all.gridlets[gridlet];
  const GridletPlaces::Steps& steps = places.steps(g.depth);
  GridletBox box;
  box.first_cell = gridlet << mesh::Gridlet::cell_bits;
  box.full = &all.full[8 * gridlet];
  box.all_full = places.all_full(gridlet);
  for (int a = 0; a < 3; ++a) {
    box.start[a] = all.lattice.origin[a] + steps.half_cell[a] * double(2 * g.lower[a] + 1);
    box.steps_a_unit[a] = steps.a_unit[a];
    box.least[a] = steps.rounding[a];
    box.most[a] = g.size[a] - steps.rounding[a];
  }
  return box;
}

/// Finds gridlets by their places. Remembers the last one, since neighbours mostly lie in one
/// (Zellmann 2023, section 5.2).
class GridletFinder {
public:
  /// hint: a cell whose gridlet is tried first, or -1. shown: a bit a gridlet, whether its cells
  /// may answer; null: all.
  explicit GridletFinder(const GridletPlaces& places, std::int64_t hint = -1,
                         const std::uint64_t* shown = nullptr)
      : places_(&places), all_(&places.gridlets()), shown_(shown) {
    if (hint >= 0)
      take(hint >> mesh::Gridlet::cell_bits);
  }

  /// Whether a cell of the last gridlet holds p strictly inside, and then which one (at: left
  /// alone otherwise), or none where the gridlet is not shown.
  bool find_in_last(const math::Vec3d& p, Location& at, Reason& reason) const {
    if (!inside(p, at))
      return false;
    reason = Reason::certified;
    if (!shows_last()) {
      at = {};
      reason = Reason::outside;
    }
    return true;
  }

  /// find_in_last() of a batch's points from the q-th on, up to one that it may not find; returns
  /// which.
  std::size_t find_ahead(std::span<const math::Vec3d> points, std::size_t q,
                         BatchAnswers& to) const {
    if (last_ < 0 || !shows_last())
      return q;
    const std::size_t end = q + cells_ahead(box_, &points[q], points.size() - q, &to.locations[q]);
    std::fill(to.reasons + q, to.reasons + end, Reason::certified);
    return end;
  }

  /// Of the last gridlet, or -1.
  int last_depth() const { return last_ < 0 ? -1 : all_->gridlets[last_].depth; }

  /// Whether another gridlet, of a depth, has the cell of an index, which then is the last. Indices
  /// are those of the leaves at cells' lower corners.
  bool take_at(int depth, const std::int64_t* index) {
    const std::int64_t found = places_->find(depth, index);
    if (found < 0 || found == last_ || !has_cell(found, index))
      return false;
    take(found);
    return true;
  }

private:
  bool has_cell(std::int64_t gridlet, const std::int64_t* index) const {
    const mesh::Gridlet& g = all_->gridlets[gridlet];
    std::int64_t cell = gridlet << mesh::Gridlet::cell_bits;
    for (int a = 0; a < 3; ++a) {
      const std::int64_t i = index[a] - g.lower[a];
      if (i < 0 || i >= g.size[a])
        return false;
      cell += i << (3 * a);
    }
    return all_->is_full(cell);
  }

  bool shows_last() const { return !shown_ || ((shown_[last_ >> 6] >> (last_ & 63)) & 1) != 0; }

  void take(std::int64_t gridlet) {
    last_ = gridlet;
    box_ = box_of(*places_, gridlet);
  }

  /// Almost all points strictly inside of the gridlet's cells, and none else.
  bool inside(const math::Vec3d& p, Location& at) const {
    if (last_ < 0)
      return false;
    double part[3];
    int bit[3];
    bool sure = true;
    for (int a = 0; a < 3; ++a) {
      const double place = (p[a] - box_.start[a]) * box_.steps_a_unit[a], least = box_.least[a];
      if (!(place > least && place < box_.most[a]))
        return false;
      bit[a] = int(place);
      part[a] = place - bit[a];
      sure &= part[a] > least && part[a] < 1.0 - least;
    }
    if (!sure || ((box_.full[bit[2]] >> (bit[0] | bit[1] << 3)) & 1) == 0)
      return false;
    at.cell = box_.first_cell | bit[0] | bit[1] << 3 | bit[2] << 6;
    for (int a = 0; a < 3; ++a)
      at.parametric[a] = part[a];
    return true;
  }

  const GridletPlaces* places_;
  const mesh::GridletsView* all_;
  const std::uint64_t* shown_;
  std::int64_t last_ = -1;
  GridletBox box_; ///< of the last
};

} // namespace insitu::query
