#pragma once

#include "advect/effects/inertia.h"
#include "advect/effects/space.h"

namespace insitu::advect {

/// The path over one accepted step of a particle with inertia: what inertial_step() integrates, at
/// any part theta of it, so as exact as its end is.
class Flight {
public:
  /// From x, a point among the cells, with velocity v and force b0, for h from time t.
  Flight(const Space& space, const Inertia& inertia, const Vec3d& x, const Vec3d& v, double t,
         double h, const Vec3d& b0, const InertialTrial& trial)
      : space_(space), inertia_(inertia), x_(x), v_(v), b0_(b0), b1_(trial.slope),
        b2_(trial.curvature), start_(t), h_(h) {}

  double start() const { return start_; }
  double step() const { return h_; }
  Vec3d at(double theta) const {
    const double s = theta * h_;
    const LinearPart part(inertia_, s);
    return x_ + space_.displacement(x_, s * part.phi(1, v_) +
                                            (s * s) * (part.phi(2, b0_) + theta * part.phi(3, b1_) +
                                                       (2.0 * theta * theta) * part.phi(4, b2_)));
  }
  Vec3d at_time(double t) const { return at((t - start_) / h_); }
  double speed(double theta) const {
    const double s = theta * h_;
    const LinearPart part(inertia_, s);
    return length_of(part.phi(0, v_) + s * (part.phi(1, b0_) + theta * part.phi(2, b1_) +
                                            (2.0 * theta * theta) * part.phi(3, b2_)));
  }

private:
  Space space_;
  const Inertia& inertia_;
  Vec3d x_, v_, b0_, b1_, b2_;
  double start_, h_;
};

} // namespace insitu::advect
