#pragma once

#include <complex>

#include "advect/effects/effects.h"
#include "advect/integrate/integrators.h"

namespace insitu::advect {

/// dv/dt = A v + b with A = -1/response_time - 2 rotation x: what is linear in a particle's
/// velocity, solved exactly over a step, however short the response time.
class LinearPart {
public:
  /// A step of length h (negative: backwards, without drag only).
  LinearPart(const Inertia& inertia, double h);

  /// phi_k(h A) w, for k = 0 to 4: phi_0 is the exponential, phi_(k+1)(z) = (phi_k(z) - 1/k!) / z.
  Vec3d phi(int k, const Vec3d& w) const;

private:
  Vec3d axis_;
  double along_[5];
  std::complex<double> around_[5]; ///< in the plane at right angles to the axis
};

/// One trial step of an inertial particle.
struct InertialTrial {
  Vec3d x, v;
  Vec3d moved;            ///< in lengths along the axes at the start, as v
  Vec3d force;            ///< b at the end, along the axes there: the next step's first stage
  Vec3d slope, curvature; ///< b as it was integrated: b0 + theta slope + theta^2 curvature
  double error = 0.0;     ///< of the position per unit time, estimated
  Sampled sampled = Sampled::inside;
};

/// Exponential time differencing of order 3 (Cox and Matthews, J. Comput. Phys. 176, 2002, ETD3RK)
/// for x' = v, v' = A v + b(x, t), with a line through the first two stages, of order 2, as the
/// embedded one. As the response time tends to 0 it becomes Kutta's method of order 3 for x' = u.
/// `force` answers b like a VelocityField, along the axes where it is asked; go(d) is where a
/// displacement takes x, and back(y, b) carries a vector from there to x's axes.
template <class Force, class Go, class Back>
InertialTrial inertial_step(Force& force, const Go& go, const Back& back, const Inertia& inertia,
                            const Vec3d& v, double t, double h, const Vec3d& b0) {
  InertialTrial trial;
  const LinearPart half(inertia, 0.5 * h), full(inertia, h);
  const double q = 0.25 * h * h, hh = h * h;
  Vec3d ba, bb;
  trial.moved = (0.5 * h) * half.phi(1, v) + q * half.phi(2, b0);
  trial.x = go(trial.moved);
  trial.sampled = force(trial.x, t + 0.5 * h, ba);
  if (trial.sampled != Sampled::inside)
    return trial;
  ba = back(trial.x, ba);
  const Vec3d free = h * full.phi(1, v);
  trial.moved = free + hh * full.phi(2, 2.0 * ba - b0);
  trial.x = go(trial.moved);
  trial.sampled = force(trial.x, t + h, bb);
  if (trial.sampled != Sampled::inside)
    return trial;
  bb = back(trial.x, bb);
  // The parabola through b at the start, the middle and the end of the step.
  const Vec3d b1 = 4.0 * ba - 3.0 * b0 - bb, b2 = 2.0 * (b0 - 2.0 * ba + bb);
  trial.moved = free + hh * (full.phi(2, b0) + full.phi(3, b1) + 2.0 * full.phi(4, b2));
  trial.v = full.phi(0, v) + h * (full.phi(1, b0) + full.phi(2, b1) + 2.0 * full.phi(3, b2));
  trial.slope = b1;
  trial.curvature = b2;
  // The line through b at the start and the middle: of order 2, and right at the end too, to which
  // v clings where the response time is short.
  const Vec3d slope = 2.0 * (ba - b0);
  const Vec3d moved2 = free + hh * (full.phi(2, b0) + full.phi(3, slope));
  const Vec3d v2 = full.phi(0, v) + h * (full.phi(1, b0) + full.phi(2, slope));
  trial.x = go(trial.moved);
  trial.sampled = force(trial.x, t + h, trial.force);
  // An error of the velocity moves the particle for the response time, or for the step.
  const double lasts = std::min(1.0, inertia.response_time / std::abs(h));
  trial.error = length_of(trial.moved - moved2) / std::abs(h) + lasts * length_of(trial.v - v2);
  return trial;
}

} // namespace insitu::advect
