#pragma once

#include "advect/integrate/integrators.h"

namespace insitu::advect {

/// The path over one accepted step, as a polynomial in theta, 0 at its start and 1 at its end.
/// dopri5: order 4 (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section
/// II.6, the coefficients of their dopri5.f); others: the cubic of Hermite through both ends'
/// positions and velocities, order 3.
class DenseStep {
public:
  DenseStep(const Vec3d& x, double t, double h, const Vec3d& k1, const Trial& trial, bool quintic)
      : start_(t), h_(h), r0_(x), r1_(trial.x - x), r2_(h * k1 - r1_),
        r3_(r1_ - h * trial.v - r2_) {
    if (quintic)
      r4_ = (h * (-12715105075.0 / 11282082432.0)) * k1 +
            (h * (87487479700.0 / 32700410799.0)) * trial.k[1] +
            (h * (-10690763975.0 / 1880347072.0)) * trial.k[2] +
            (h * (701980252875.0 / 199316789632.0)) * trial.k[3] +
            (h * (-1453857185.0 / 822651844.0)) * trial.k[4] +
            (h * (69997945.0 / 29380423.0)) * trial.v;
  }

  /// Its part up to theta: the path of a shorter step.
  DenseStep until(double theta) const {
    DenseStep part = *this;
    part.h_ = theta * h_;
    part.r1_ = at(theta) - r0_;
    part.r2_ = theta * rate(0.0) - part.r1_;
    part.r3_ = part.r1_ - theta * rate(theta) - part.r2_;
    const double square = theta * theta;
    part.r4_ = (square * square) * r4_; // the coefficient of theta^4
    return part;
  }

  double start() const { return start_; } ///< time
  double step() const { return h_; }      ///< negative backwards
  Vec3d at(double theta) const {
    const double rest = 1.0 - theta;
    return r0_ + theta * (r1_ + rest * (r2_ + theta * (r3_ + rest * r4_)));
  }
  /// Its derivative with theta.
  Vec3d rate(double theta) const {
    const double rest = 1.0 - theta;
    const Vec3d a = r3_ + rest * r4_, b = r2_ + theta * a, c = r1_ + rest * b;
    return c + theta * (rest * (a - theta * r4_) - b);
  }
  /// The position at a time within the step.
  Vec3d at_time(double t) const { return at((t - start_) / h_); }

private:
  double start_, h_;
  Vec3d r0_, r1_, r2_, r3_, r4_;
};

} // namespace insitu::advect
