#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>

#include "math/vec.h"

namespace insitu::advect {

using math::Vec3d;

/// What a velocity field answers at a point and a time.
enum class Sampled : std::uint8_t { inside, outside, not_finite };

/// A velocity field dx/dt = v(x, t). It is asked at trial points; accepted() tells it that the
/// point asked last is the particle's new position, and extent() is then the size, along x, y and
/// z, of the cell around that position: the measure of steps and of where a particle leaves. It is
/// positive, and infinite for an unbounded field without cells.
template <class F>
concept VelocityField = requires(F& f, const Vec3d& x, double t, Vec3d& v) {
  { f(x, t, v) } -> std::same_as<Sampled>;
  f.accepted();
  { f.extent() } -> std::convertible_to<Vec3d>;
};

/// Euclidean length without overflow or underflow in between.
inline double length_of(const Vec3d& v) {
  return std::hypot(v.x, v.y, v.z);
}

/// What a displacement d at the position x measures in the units of lengths and tolerances: for
/// error vectors per unit time as well, and so for speeds. A field whose coordinates are not
/// lengths, such as degrees, has a double length(x, d), linear in the size of d; others cost
/// nothing.
template <class F>
double measure(const F& field, const Vec3d& x, const Vec3d& d) {
  if constexpr (requires {
                  { field.length(x, d) } -> std::same_as<double>;
                })
    return field.length(x, d);
  else
    return length_of(d);
}

/// One trial step.
struct Trial {
  Vec3d x;            ///< the end; if not inside, the stage that failed
  Vec3d v;            ///< the velocity there: the next step's first stage
  double error = 0.0; ///< estimated error per unit time, |difference of orders| / |h|
  Sampled sampled = Sampled::inside; ///< of the first stage that failed
};

/// Kutta's classical method of order 4 (Kutta 1901). k1 is the velocity at (x, t); h may be
/// negative. Four evaluations, the last of them at the end of the step.
template <VelocityField F>
Trial rk4_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1);

/// Dormand and Prince's embedded pair 5(4) with first-same-as-last (J. Comput. Appl. Math. 6, 1980,
/// their RK5(4)7M), advanced in the higher order. Six evaluations, the last at the end.
template <VelocityField F>
Trial dopri5_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1);

// ---------------------------------------------------------------------------- implementation

template <VelocityField F>
Trial rk4_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1) {
  Trial trial;
  Vec3d k2, k3, k4;
  // Products with h come first: velocities may be near the largest double.
  const auto stage = [&](double c, const Vec3d& at, Vec3d& k) {
    trial.x = at;
    trial.sampled = velocity(at, t + c * h, k);
    return trial.sampled == Sampled::inside;
  };
  if (stage(0.5, x + (0.5 * h) * k1, k2) && stage(0.5, x + (0.5 * h) * k2, k3) &&
      stage(1.0, x + h * k3, k4))
    stage(1.0, x + ((h / 6) * k1 + (h / 3) * k2 + (h / 3) * k3 + (h / 6) * k4), trial.v);
  return trial;
}

template <VelocityField F>
Trial dopri5_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1) {
  Trial trial;
  Vec3d k2, k3, k4, k5, k6;
  const auto stage = [&](double c, const Vec3d& at, Vec3d& k) {
    trial.x = at;
    trial.sampled = velocity(at, t + c * h, k);
    return trial.sampled == Sampled::inside;
  };
  // clang-format off
  if (!stage(1.0 / 5, x + (h / 5) * k1, k2))
    return trial;
  if (!stage(3.0 / 10, x + ((h * (3.0 / 40)) * k1 + (h * (9.0 / 40)) * k2), k3))
    return trial;
  if (!stage(4.0 / 5, x + ((h * (44.0 / 45)) * k1 + (h * (-56.0 / 15)) * k2 + (h * (32.0 / 9)) * k3), k4))
    return trial;
  if (!stage(8.0 / 9, x + ((h * (19372.0 / 6561)) * k1 + (h * (-25360.0 / 2187)) * k2
                         + (h * (64448.0 / 6561)) * k3 + (h * (-212.0 / 729)) * k4), k5))
    return trial;
  if (!stage(1.0, x + ((h * (9017.0 / 3168)) * k1 + (h * (-355.0 / 33)) * k2 + (h * (46732.0 / 5247)) * k3
                     + (h * (49.0 / 176)) * k4 + (h * (-5103.0 / 18656)) * k5), k6))
    return trial;
  if (!stage(1.0, x + ((h * (35.0 / 384)) * k1 + (h * (500.0 / 1113)) * k3 + (h * (125.0 / 192)) * k4
                     + (h * (-2187.0 / 6784)) * k5 + (h * (11.0 / 84)) * k6), trial.v))
    return trial;
  trial.error = measure(velocity, x, (71.0 / 57600) * k1 + (-71.0 / 16695) * k3 + (71.0 / 1920) * k4
                        + (-17253.0 / 339200) * k5 + (22.0 / 525) * k6 + (-1.0 / 40) * trial.v);
  // clang-format on
  return trial;
}

} // namespace insitu::advect
