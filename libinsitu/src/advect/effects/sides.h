#pragma once

#include <cmath>

#include "advect/effects/effects.h"
#include "advect/effects/space.h"
#include "advect/field/box.h"
#include "core/parallel.h"
#include "parallel/world.h"
#include "query/sampler.h"

namespace insitu::advect {

/// The periodic sides of a mesh: what leaves its box at one of them comes in at the opposite one.
/// On a geodetic mesh they are meridians, with the way around the Earth that the mesh takes between
/// them; a rotation about the Earth's axis takes one to the other, so metres, east and north are
/// the same on both.
class Sides {
public:
  Sides() = default; ///< none
  /// box: in the cells' coordinates. turn: of a geodetic mesh, of its longitudes, which in the box
  /// go on over the seam; else 0.
  Sides(const Box& box, const bool (&periodic)[3], double turn = 0.0) : box_(box), turn_(turn) {
    for (int a = 0; a < 3; ++a)
      period_[a] = periodic[a] ? std::max(0.0, box.high[a] - box.low[a]) : 0.0;
  }

  const Box& box() const { return box_; }
  bool is_periodic(int axis) const { return period_[axis] > 0.0; }
  bool any() const { return is_periodic(0) || is_periodic(1) || is_periodic(2); }

  /// The coordinate of the higher or the lower side, and how far beyond it x is.
  double at(int axis, bool high) const { return high ? box_.high[axis] : box_.low[axis]; }
  double beyond(const Vec3d& x, int axis, bool high) const {
    const double d = x[axis] - at(axis, high);
    return axis == 0 && turn_ > 0.0 ? std::remainder(d, turn_) : d;
  }

  /// The displacement from x to y by the shortest way through the mesh and its periodic sides, on
  /// one sheet of a chart.
  Vec3d between(const Vec3d& x, const Vec3d& y) const {
    Vec3d d = named(y) - named(x);
    for (int a = 0; a < 3; ++a)
      if (is_periodic(a))
        d[a] -= period_[a] * std::round(d[a] / period_[a]);
    return d;
  }
  /// x with its longitude among those of the box.
  Vec3d named(Vec3d x) const {
    if (turn_ > 0.0) {
      const double middle = 0.5 * (box_.low.x + box_.high.x);
      x.x -= turn_ * std::round((x.x - middle) / turn_);
    }
    return x;
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
  double turn_ = 0.0;
  double period_[3] = {}; ///< 0: not periodic
};

/// The straight way between two points among the cells that are near each other, through periodic
/// sides if that is shorter.
class Way {
public:
  Way(const Space& space, const Sides& sides, const Vec3d& from, const Vec3d& to)
      : space_(space), sides_(&sides),
        from_(sides.any() ? sides.named(from) : space.across(from, space.pole_of(from), to, from)),
        to_(sides.any() ? sides.named(to) : to), d_(sides.between(from_, to_)) {}

  const Vec3d& displacement() const { return d_; }

  /// The point after a part of it.
  Vec3d at(double part) const { return image(sides_->within(from_ + part * d_)); }
  /// The same on the parabola with these ends whose beginning points along displacement() + bend.
  Vec3d at(double part, const Vec3d& bend) const {
    return image(sides_->within(from_ + part * (d_ + (1.0 - part) * bend)));
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
    before = image(before);
    after = image(after);
    return first;
  }

private:
  bool passes(int a) const { return d_[a] != to_[a] - from_[a]; }
  /// Where there are sides no cell is on a turned chart, though the box's names may look like it.
  Vec3d image(const Vec3d& x) const {
    return space_.image(x, sides_->any() ? geo::Pole::none : space_.pole_of(to_));
  }
  bool is_high(int a) const { return to_[a] < from_[a]; } ///< the side that it goes out at

  Space space_;
  const Sides* sides_;
  Vec3d from_, to_, d_;
};

/// The sides of this boundary's periodic axes. A geodetic mesh has them in longitude, unless it
/// goes around the Earth, which it does without; throws Error(INSITU_ERROR_UNSUPPORTED) for other
/// axes of it, and if it has cells on a chart turned to a pole.
Sides sides_of(const query::Sampler& sampler, const BoundaryEffect& boundary,
               const core::Threads& threads);
/// The sides in longitude of the meshes of all processes. Collective; none where this one has no
/// chart. Throws parallel::AgreedError.
Sides meridians_of(const query::Sampler& sampler, const core::Threads& threads,
                   parallel::World& world);

} // namespace insitu::advect
