#pragma once

#include <cmath>
#include <cstdint>

#include "cells/decide.h"
#include "mesh/view.h"
#include "query/gridlet_places.h"
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

/// A vertex field's components in a cell of a gridlet. Vertices along i lie side by side.
inline void interpolate_in_gridlet(const mesh::GridletsView& all, const mesh::FieldView& field,
                                   std::int64_t cell, const math::Vec3d& r, double* values) {
  const mesh::Gridlet& g = all.gridlets[cell >> mesh::Gridlet::cell_bits];
  const std::int64_t v =
      mesh::GridletsView::first_vertex(g, int(cell & (mesh::Gridlet::most_cells - 1)));
  const std::int64_t dj = g.size[0] + 1, dk = dj * (g.size[1] + 1);
  const mesh::FieldPieceView& from = field.pieces[0];
  const double i1 = r.x, i0 = 1.0 - i1, j1 = r.y, j0 = 1.0 - j1, k1 = r.z, k0 = 1.0 - k1;
  const std::int64_t stride = from.layout.stride[0];
  for (int c = 0; c < field.components; ++c) {
    const std::byte* const base = from.component[c] + v * stride;
    const auto row = [&](std::int64_t vertices) {
      const std::byte* const at = base + vertices * stride;
      return from.is_float32
                 ? i0 * double(mesh::load_as<float>(at)) +
                       i1 * double(mesh::load_as<float>(at + stride))
                 : i0 * mesh::load_as<double>(at) + i1 * mesh::load_as<double>(at + stride);
    };
    values[c] = k0 * (j0 * row(0) + j1 * row(dj)) + k1 * (j0 * row(dk) + j1 * row(dk + dj));
  }
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
    for (int a = 0; a < 3; ++a)
      per_unit_[a] = 1.0 / all_->lattice.spacing[a];
    if (hint >= 0)
      take(hint >> mesh::Gridlet::cell_bits);
  }

  static constexpr bool finds_all = false;

  /// Whether a cell of a gridlet holds p strictly inside, and then which one (at: left alone
  /// otherwise), or none where the gridlet is not shown; if not, it may be in any cell. What it
  /// answers does not depend on the points before.
  bool find(const math::Vec3d& p, Location& at, Reason& reason) {
    reason = Reason::certified;
    if (inside(p, at))
      return hide(at, reason);
    for (int d = 0; d < places_->depth_count(); ++d) {
      const int depth = places_->depth(d);
      const double scale = double(std::int64_t(1) << depth);
      std::int64_t index[3]; // of the dual cell there: these begin at centres
      bool near = true;
      for (int a = 0; a < 3; ++a) {
        const double steps = (p[a] - all_->lattice.origin[a]) * (per_unit_[a] * scale) - 0.5;
        near &= std::fabs(steps) < double(2 * mesh::Lattice::largest_index);
        index[a] = near ? std::int64_t(steps) : 0;
        index[a] -= steps < double(index[a]);
      }
      const std::int64_t found = near ? places_->find(depth, index) : -1;
      if (found < 0 || found == last_ || !has_cell(found, index))
        continue;
      take(found);
      if (inside(p, at))
        return hide(at, reason);
    }
    return false;
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

  /// True in any case.
  bool hide(Location& at, Reason& reason) const {
    if (shown_ && !((shown_[last_ >> 6] >> (last_ & 63)) & 1)) {
      at = {};
      reason = Reason::outside;
    }
    return true;
  }

  void take(std::int64_t gridlet) {
    const mesh::Gridlet& g = all_->gridlets[gridlet];
    last_ = gridlet;
    const double scale = double(std::int64_t(1) << g.depth);
    for (int a = 0; a < 3; ++a) {
      start_[a] = all_->coordinate(g, a, 0);
      steps_a_unit_[a] = per_unit_[a] * scale;
      // Some units in the last place of the coordinates, of zero's and of the lattice's origin, in
      // steps: nearer to a face, an index found by either may be the neighbour's.
      const double far = std::fabs(start_[a]) + std::fabs(start_[a] - all_->lattice.origin[a]);
      const double rounding = 0x1p-49 * (far * steps_a_unit_[a] + 16.0);
      least_[a] = rounding;
      most_[a] = g.size[a] - rounding;
    }
  }

  /// Almost all points strictly inside of the gridlet's cells, and none else.
  bool inside(const math::Vec3d& p, Location& at) const {
    if (last_ < 0)
      return false;
    double part[3];
    std::int64_t cell = last_ << mesh::Gridlet::cell_bits;
    bool sure = true;
    for (int a = 0; a < 3; ++a) {
      const double steps = (p[a] - start_[a]) * steps_a_unit_[a];
      if (!(steps > least_[a] && steps < most_[a]))
        return false;
      const int i = int(steps);
      part[a] = steps - i;
      sure &= part[a] > least_[a] && part[a] < 1.0 - least_[a];
      cell += i << (3 * a);
    }
    if (!sure || !all_->is_full(cell))
      return false;
    at.cell = cell;
    for (int a = 0; a < 3; ++a)
      at.parametric[a] = part[a];
    return true;
  }

  const GridletPlaces* places_;
  const mesh::GridletsView* all_;
  const std::uint64_t* shown_;
  std::int64_t last_ = -1;
  double per_unit_[3]; ///< cells of depth 0
  // Of the last gridlet:
  double start_[3], steps_a_unit_[3], least_[3], most_[3];
};

} // namespace insitu::query
