#pragma once

#include <cmath>
#include <cstdint>

#include "amr/dual/corner_map.h"
#include "math/expansion.h"
#include "mesh/lattice.h"
#include "query/location.h"

namespace insitu::query {

/// Where a point is among the frusta of a depth: as far as bounds on rounding tell, and for points
/// on or very near their sides by exact arithmetic.
class FrustumSides {
public:
  FrustumSides(const mesh::Lattice& lattice, const amr::CornerMap& map) : lattice_(&lattice) {
    for (int a = 0; a < 3; ++a) {
      per_unit_[a] = 1.0 / lattice.spacing[a];
      // Some units in the last place of the coordinates in cells there, and of those from the
      // origin.
      rounding_[a] =
          0x1p-49 * (std::fabs(lattice.origin[a]) * per_unit_[a] + 2.0 * (map.farthest(a) + 1.0));
    }
  }
  const mesh::Lattice& lattice() const { return *lattice_; }

  /// A point as a depth sees it.
  struct Place {
    int depth;
    double steps_a_unit[3];
    double steps[3];    ///< cells from the lattice's origin
    double rounding[3]; ///< of differences of coordinates there, in cells
    std::int64_t floor[3];
  };
  Place place(const math::Vec3d& p, int depth) const;

  /// The sections of frusta of a kind at the point: weights of the coarser leaves' rectangle and of
  /// the others'.
  struct Sections {
    amr::CornerKind kind;
    double coarse, fine;
    double rounding; ///< of their sides, in cells
  };

  /// Moves the corner along an axis across the frusta's to the one whose sides p is between, as far
  /// as floating point and exact arithmetic can tell, from the next one at most. part: of the way
  /// from its lower side. on: 0, or the direction of the side that p is on.
  bool within(const math::Vec3d& p, const Place& place, const Sections& at_point,
              std::int64_t* corner, int axis, double& part, int& on, Reason& reason) const;

private:
  static constexpr int unknown = 2;

  /// Across the section at the point, along one axis, cells from the corner.
  struct Section {
    double low, high;
  };
  /// From the corner to the coarser leaves' centres along an axis across the frustum's, in cells.
  static Section coarse_section(std::int64_t corner, int up) {
    const std::int64_t width = std::int64_t(1) << up, past = corner & (width - 1);
    const std::int64_t high = width / 2 - past;
    return {double(high - (past == 0 ? width : 0)), double(high)};
  }
  /// On which side of a frustum's side a point lies that is between its ends: 1 within, 0 on it, -1
  /// beyond, or unknown. The side is that along an axis in a direction, -1 or 1.
  int side_of(const math::Vec3d& p, int depth, amr::CornerKind kind, const std::int64_t* corner,
              int axis, int direction) const;

  const mesh::Lattice* lattice_;
  double per_unit_[3]; ///< cells of depth 0
  double rounding_[3]; ///< of differences of coordinates, in cells of depth 0
};

// Implementation

inline FrustumSides::Place FrustumSides::place(const math::Vec3d& p, int depth) const {
  Place at;
  at.depth = depth;
  const double scale = double(std::int64_t(1) << depth);
  for (int a = 0; a < 3; ++a) {
    at.steps_a_unit[a] = per_unit_[a] * scale;
    at.steps[a] = (p[a] - lattice_->origin[a]) * at.steps_a_unit[a];
    // Those far from all cells are as good as none.
    const double near =
        std::fabs(at.steps[a]) < double(mesh::Lattice::largest_index) ? at.steps[a] : 0.0;
    at.floor[a] = std::int64_t(near);
    at.floor[a] -= near < double(at.floor[a]);
    // Also of distances of a few cells. Points farther away than any cell are in none for certain.
    at.rounding[a] = rounding_[a] * scale + 0x1p-45;
  }
  return at;
}

[[gnu::always_inline]] inline bool
FrustumSides::within(const math::Vec3d& p, const Place& place, const Sections& at_point,
                     std::int64_t* corner, int axis, double& part, int& on, Reason& reason) const {
  const double near = place.rounding[axis] + at_point.rounding; // where rounding may err
  double above, below;
  const auto look = [&] {
    const Section centres = coarse_section(corner[axis], at_point.kind.up());
    const double x =
        (p[axis] - lattice_->place(axis, place.depth, 2 * corner[axis])) * place.steps_a_unit[axis];
    above = x - (at_point.coarse * centres.low - 0.5 * at_point.fine);
    below = (at_point.coarse * centres.high + 0.5 * at_point.fine) - x;
    part = above / (above + below);
    return above + below > 8.0 * near;
  };
  const bool wide = look();
  if (above > near && below > near)
    return true;
  const int direction = above > below ? 1 : -1;
  if (!wide || !(std::fmin(above, below) > -2.0 * near))
    return false; // too near to the apex, or a wrong guess
  const int where = side_of(p, place.depth, at_point.kind, corner, axis, direction);
  if (where == unknown)
    return false;
  if (where < 0) {
    corner[axis] += direction;
    if (!look())
      return false;
  }
  part = std::fmin(std::fmax(part, 0.0), 1.0);
  if (where == 0) {
    on = direction;
    part = direction > 0 ? 1.0 : 0.0;
  }
  reason = Reason::exact;
  return true;
}

inline int FrustumSides::side_of(const math::Vec3d& p, int depth, amr::CornerKind kind,
                                 const std::int64_t* corner, int axis, int direction) const {
  const int across = kind.axis(), to = kind.side() ? 1 : -1;
  const std::int64_t width = std::int64_t(1) << kind.up();
  const Section centres = coarse_section(corner[axis], kind.up());
  const auto place = [&](int a, std::int64_t halves) { return lattice_->place(a, depth, halves); };
  const double fine_x = place(axis, 2 * corner[axis] + direction);
  const double coarse_x =
      place(axis, 2 * corner[axis] + 2 * std::int64_t(direction > 0 ? centres.high : centres.low));
  const double fine_z = place(across, 2 * corner[across] - to);
  const double coarse_z = place(across, 2 * corner[across] + to * width);
  // The sign of (p - fine)_x (coarse - fine)_z - (p - fine)_z (coarse - fine)_x.
  const math::DoubleDouble x = math::two_difference(p[axis], fine_x),
                           z = math::two_difference(p[across], fine_z),
                           rise = math::two_difference(coarse_z, fine_z),
                           run = math::two_difference(coarse_x, fine_x);
  if (x.lo != 0.0 || z.lo != 0.0 || rise.lo != 0.0 || run.lo != 0.0)
    return unknown;
  constexpr double least = 0x1p-900, most = 0x1p900; // of exact products
  const math::DoubleDouble left = math::two_product(x.hi, rise.hi),
                           right = math::two_product(z.hi, run.hi);
  for (const double size : {std::fabs(left.hi), std::fabs(right.hi)})
    if (size != 0.0 && !(size > least && size < most))
      return unknown;
  // Products rounded to nearest keep their order.
  const int sign = left.hi != right.hi   ? (left.hi > right.hi ? 1 : -1)
                   : left.lo != right.lo ? (left.lo > right.lo ? 1 : -1)
                                         : 0;
  return -sign * direction * (rise.hi > 0.0 ? 1 : -1);
}

} // namespace insitu::query
