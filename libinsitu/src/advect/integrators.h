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
  Vec3d x;     ///< the end; if not inside, the stage that failed
  Vec3d v;     ///< the velocity there: the next step's first stage
  Vec3d error; ///< estimated error per unit time: the difference of two orders / h; 0 without one
  Vec3d k[4];  ///< dopri5: stages 3 to 6, for the dense output
  Sampled sampled = Sampled::inside; ///< of the first stage that failed
};

/// Euler's method, order 1. k1 is the velocity at (x, t); h may be negative. One evaluation, at the
/// end of the step; so for the others, whose last is there too.
template <VelocityField F>
Trial euler_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1);

/// Kutta's classical method of order 4 (Kutta 1901). Four evaluations.
template <VelocityField F>
Trial rk4_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1);

/// Bogacki and Shampine's embedded pair 3(2) with first-same-as-last (Appl. Math. Lett. 2, 1989),
/// advanced in the higher order. Three evaluations.
template <VelocityField F>
Trial bs32_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1);

/// Dormand and Prince's embedded pair 5(4) with first-same-as-last (J. Comput. Appl. Math. 6, 1980,
/// their RK5(4)7M), advanced in the higher order. Six evaluations.
template <VelocityField F>
Trial dopri5_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1);

/// A method as integrate() needs it. error_order: q, the estimate per unit time falls as h^q.
/// cells: crossed by one step at most, where its size follows from the cell.
struct Euler {
  static constexpr bool adaptive = false, quintic = false;
  static constexpr int order = 1, error_order = 1, evaluations = 1;
  static constexpr double cells = 0.25;
  template <VelocityField F>
  static Trial step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1) {
    return euler_step(velocity, x, t, h, k1);
  }
};
struct Rk4 {
  static constexpr bool adaptive = false, quintic = false;
  static constexpr int order = 4, error_order = 4, evaluations = 4;
  static constexpr double cells = 0.25;
  template <VelocityField F>
  static Trial step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1) {
    return rk4_step(velocity, x, t, h, k1);
  }
};
struct Bs32 {
  static constexpr bool adaptive = true, quintic = false;
  static constexpr int order = 3, error_order = 2, evaluations = 3;
  static constexpr double cells = 1.0;
  template <VelocityField F>
  static Trial step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1) {
    return bs32_step(velocity, x, t, h, k1);
  }
};
struct Dopri5 {
  static constexpr bool adaptive = true, quintic = true; ///< a dense output of its own
  static constexpr int order = 5, error_order = 4, evaluations = 6;
  static constexpr double cells = 1.0;
  template <VelocityField F>
  static Trial step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1) {
    return dopri5_step(velocity, x, t, h, k1);
  }
};

// ---------------------------------------------------------------------------- implementation

template <VelocityField F>
Trial euler_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1) {
  Trial trial;
  trial.x = x + h * k1;
  trial.sampled = velocity(trial.x, t + h, trial.v);
  return trial;
}

template <VelocityField F>
Trial bs32_step(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1) {
  Trial trial;
  Vec3d k2, k3;
  const auto stage = [&](double c, const Vec3d& at, Vec3d& k) {
    trial.x = at;
    trial.sampled = velocity(at, t + c * h, k);
    return trial.sampled == Sampled::inside;
  };
  if (stage(1.0 / 2, x + (h / 2) * k1, k2) && stage(3.0 / 4, x + (h * (3.0 / 4)) * k2, k3) &&
      stage(1.0, x + ((h * (2.0 / 9)) * k1 + (h / 3) * k2 + (h * (4.0 / 9)) * k3), trial.v))
    trial.error = (-5.0 / 72) * k1 + (1.0 / 12) * k2 + (1.0 / 9) * k3 + (-1.0 / 8) * trial.v;
  return trial;
}

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
  Vec3d k2;
  auto& [k3, k4, k5, k6] = trial.k;
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
  trial.error = (71.0 / 57600) * k1 + (-71.0 / 16695) * k3 + (71.0 / 1920) * k4
              + (-17253.0 / 339200) * k5 + (22.0 / 525) * k6 + (-1.0 / 40) * trial.v;
  // clang-format on
  return trial;
}

} // namespace insitu::advect
