#pragma once

#include <cmath>

#include "advect/box.h"
#include "advect/effects.h"
#include "advect/space.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::advect {

/// The periodic sides of a mesh: what leaves its box at one of them comes in at the opposite one.
class Sides {
public:
  Sides() = default; ///< none
  /// box: in the cells' coordinates.
  Sides(const Box& box, const bool (&periodic)[3]) : box_(box) {
    for (int a = 0; a < 3; ++a)
      period_[a] = periodic[a] ? std::max(0.0, box.high[a] - box.low[a]) : 0.0;
  }

  bool is_periodic(int axis) const { return period_[axis] > 0.0; }
  bool any() const { return is_periodic(0) || is_periodic(1) || is_periodic(2); }

  /// The coordinate of the higher or the lower side.
  double at(int axis, bool high) const { return high ? box_.high[axis] : box_.low[axis]; }

  /// The displacement that comes to the same place by the shortest way.
  Vec3d shortest(Vec3d d) const {
    for (int a = 0; a < 3; ++a)
      if (is_periodic(a))
        d[a] -= period_[a] * std::round(d[a] / period_[a]);
    return d;
  }
  /// The place within the box that a point less than a period outside is.
  Vec3d within(Vec3d x) const {
    for (int a = 0; a < 3; ++a)
      if (is_periodic(a))
        x[a] = x[a] < box_.low[a]    ? x[a] + period_[a]
               : x[a] > box_.high[a] ? x[a] - period_[a]
                                     : x[a];
    return x;
  }

private:
  Box box_;
  double period_[3] = {}; ///< 0: not periodic
};

/// The straight way between two points among the cells that are near each other, through periodic
/// sides if that is shorter.
class Way {
public:
  Way(const Space& space, const Sides& sides, const Vec3d& from, const Vec3d& to)
      : space_(space), sides_(&sides), from_(space.across(from, space.pole_of(from), to, from)),
        to_(to), d_(sides.shortest(to - from_)) {}

  /// The point after a part of it.
  Vec3d at(double part) const {
    return space_.image(sides_->within(from_ + part * d_), space_.pole_of(to_));
  }
  bool passes_side() const { return passes(0) || passes(1) || passes(2); }
  /// The part of it at which it comes to the periodic side that it passes (of several, to the
  /// first), with the points on that and on the opposite side, to the bit.
  double side(Vec3d& before, Vec3d& after) const {
    double first = 1.0;
    int axis = 0;
    for (int a = 0; a < 3; ++a) {
      if (!passes(a))
        continue;
      const double part = d_[a] != 0.0 ? (sides_->at(a, is_high(a)) - from_[a]) / d_[a] : 0.0;
      if (part <= first) {
        first = std::max(part, 0.0);
        axis = a;
      }
    }
    before = after = sides_->within(from_ + first * d_);
    before[axis] = sides_->at(axis, is_high(axis));
    after[axis] = sides_->at(axis, !is_high(axis));
    return first;
  }

private:
  bool passes(int a) const { return d_[a] != to_[a] - from_[a]; }
  bool is_high(int a) const { return to_[a] < from_[a]; } ///< the side that it goes out at

  Space space_;
  const Sides* sides_;
  Vec3d from_, to_, d_;
};

/// The sides of this boundary's periodic axes.
Sides sides_of(const mesh::MeshView& mesh, const BoundaryEffect& boundary,
               const core::Threads& threads);

} // namespace insitu::advect
