#pragma once

#include "advect/integrate/fields.h"
#include "advect/integrate/kutta.h"

namespace insitu::advect {

/// One trial step.
struct Trial {
  Vec3d x;     ///< the end; if not inside, the stage that failed
  Vec3d v;     ///< the velocity there: the next step's first stage
  Vec3d error; ///< estimated error per unit time: the difference of two orders / h; 0 without one
  Vec3d k[6];  ///< velocities of the stages from the second on, those that the method has
  Sampled sampled = Sampled::inside; ///< of the first stage that failed
};

/// A method as integrations need it, in stages: from the velocity k1 at the begin of a step,
/// evaluation s (from 0) is asked at point(s, ...), time(s) of the step on, and the last
/// is at its end, so that it is the next step's first. Then finish() estimates the error. The step
/// h may be negative. error_order: q, the estimate per unit time falls as h^q. cells: crossed by
/// one step at most, where its size follows from the cell. quintic: has a dense output of its own.
///
/// Products with h come first: velocities may be near the largest double.

/// Euler's, of order 1.
struct Euler {
  static constexpr bool adaptive = false, quintic = false;
  static constexpr int order = 1, error_order = 1, evaluations = 1;
  static constexpr double cells = 0.25;
  static constexpr double time(int) { return 1.0; }
  static Vec3d point(int, const Vec3d& x, double h, const Vec3d& k1, const Trial&) {
    return x + h * k1;
  }
  static void finish(Trial&, const Vec3d&) {}
};

/// Kutta's classical method of order 4 (Kutta 1901).
struct Rk4 {
  static constexpr bool adaptive = false, quintic = false;
  static constexpr int order = 4, error_order = 4, evaluations = 4;
  static constexpr double cells = 0.25;
  static constexpr double time(int s) { return s < 2 ? 0.5 : 1.0; }
  static Vec3d point(int s, const Vec3d& x, double h, const Vec3d& k1, const Trial& trial);
  static void finish(Trial&, const Vec3d&) {}
};

/// Bogacki and Shampine's embedded pair 3(2) with first-same-as-last (Appl. Math. Lett. 2, 1989),
/// advanced in the higher order.
struct Bs32 {
  static constexpr bool adaptive = true, quintic = false;
  static constexpr int order = 3, error_order = 2, evaluations = 3;
  static constexpr double cells = 1.0;
  static constexpr double time(int s) { return s == 0 ? 1.0 / 2 : s == 1 ? 3.0 / 4 : 1.0; }
  static Vec3d point(int s, const Vec3d& x, double h, const Vec3d& k1, const Trial& trial);
  static void finish(Trial& trial, const Vec3d& k1);
};

/// Dormand and Prince's embedded pair 5(4) with first-same-as-last (J. Comput. Appl. Math. 6, 1980,
/// their RK5(4)7M), advanced in the higher order.
struct Dopri5 {
  static constexpr bool adaptive = true, quintic = true;
  static constexpr int order = 5, error_order = 4, evaluations = 6;
  static constexpr double cells = 1.0;
  static constexpr double time(int s) {
    constexpr double c[] = {1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
    return c[s];
  }
  static Vec3d point(int s, const Vec3d& x, double h, const Vec3d& k1, const Trial& trial);
  static void finish(Trial& trial, const Vec3d& k1);
};

/// A trial by method M at once, as integration() makes it stage by stage.
template <class M, VelocityField F>
Trial trial_of(F& velocity, const Vec3d& x, double t, double h, const Vec3d& k1) {
  Trial trial;
  for (int s = 0; s < M::evaluations; ++s) {
    trial.x = M::point(s, x, h, k1, trial);
    trial.sampled = velocity(trial.x, t + M::time(s) * h, trial.k[s]);
    if (trial.sampled != Sampled::inside)
      return trial;
  }
  trial.v = trial.k[M::evaluations - 1];
  M::finish(trial, k1);
  return trial;
}

// ---------------------------------------------------------------------------- implementation

inline Vec3d Rk4::point(int s, const Vec3d& x, double h, const Vec3d& k1, const Trial& trial) {
  return kutta_point(s, x, h, k1, trial.k[0], trial.k[1], trial.k[2]);
}

inline Vec3d Bs32::point(int s, const Vec3d& x, double h, const Vec3d& k1, const Trial& trial) {
  const auto& [k2, k3, k4, k5, k6, k7] = trial.k;
  switch (s) {
  case 0:
    return x + (h / 2) * k1;
  case 1:
    return x + (h * (3.0 / 4)) * k2;
  default:
    return x + ((h * (2.0 / 9)) * k1 + (h / 3) * k2 + (h * (4.0 / 9)) * k3);
  }
}

inline void Bs32::finish(Trial& trial, const Vec3d& k1) {
  trial.error =
      (-5.0 / 72) * k1 + (1.0 / 12) * trial.k[0] + (1.0 / 9) * trial.k[1] + (-1.0 / 8) * trial.v;
}

// clang-format off
inline Vec3d Dopri5::point(int s, const Vec3d& x, double h, const Vec3d& k1, const Trial& trial) {
  const auto& [k2, k3, k4, k5, k6, k7] = trial.k;
  switch (s) {
  case 0: return x + (h / 5) * k1;
  case 1: return x + ((h * (3.0 / 40)) * k1 + (h * (9.0 / 40)) * k2);
  case 2: return x + ((h * (44.0 / 45)) * k1 + (h * (-56.0 / 15)) * k2 + (h * (32.0 / 9)) * k3);
  case 3: return x + ((h * (19372.0 / 6561)) * k1 + (h * (-25360.0 / 2187)) * k2
                    + (h * (64448.0 / 6561)) * k3 + (h * (-212.0 / 729)) * k4);
  case 4: return x + ((h * (9017.0 / 3168)) * k1 + (h * (-355.0 / 33)) * k2
                    + (h * (46732.0 / 5247)) * k3 + (h * (49.0 / 176)) * k4
                    + (h * (-5103.0 / 18656)) * k5);
  default: return x + ((h * (35.0 / 384)) * k1 + (h * (500.0 / 1113)) * k3
                     + (h * (125.0 / 192)) * k4 + (h * (-2187.0 / 6784)) * k5
                     + (h * (11.0 / 84)) * k6);
  }
}

inline void Dopri5::finish(Trial& trial, const Vec3d& k1) {
  const auto& [k2, k3, k4, k5, k6, k7] = trial.k;
  trial.error = (71.0 / 57600) * k1 + (-71.0 / 16695) * k3 + (71.0 / 1920) * k4
              + (-17253.0 / 339200) * k5 + (22.0 / 525) * k6 + (-1.0 / 40) * trial.v;
}
// clang-format on

} // namespace insitu::advect
