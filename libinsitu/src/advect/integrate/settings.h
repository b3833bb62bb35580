#pragma once

#include <cstdint>

#include "math/vec.h"

/// Settings by which particles are moved, and what moving them cost; integrate.h moves them.
namespace insitu::advect {

using math::Vec3d;

enum class Method : std::uint8_t { euler, rk4, bs32, dopri5 };

/// Returns whether a method chooses its steps by their errors. Any other method has fixed steps.
constexpr bool is_adaptive(Method method) {
  return method == Method::bs32 || method == Method::dopri5;
}

/// How the value of a field between the steps n - 1 and n follows from its values at the steps up
/// to n.
enum class TimeInterpolation : std::uint8_t {
  linear,    ///< the straight line: takes 2 steps, and has order 2 in the time between steps
  quadratic, ///< the parabola through the last three steps, of order 3
  cubic ///< Hermite's cubic by slopes at both ends. Each slope is that of the parabola through the
        ///< step and the two before it, so that the slope is continuous from interval to interval.
        ///< Takes 4 steps; has order 4 where the steps are even, 3 where they are not
};

/// Returns how many steps an interpolation takes, the current one included.
constexpr int steps_of(TimeInterpolation interpolation) {
  return int(interpolation) + 2;
}
inline constexpr int most_steps = 4;

/// What becomes of a particle where error control wants steps below a min_step that is given.
enum class AtMinStep : std::uint8_t {
  end, ///< the particle ends there: INSITU_END_STEP_TOO_SMALL
  take ///< the particle takes the step, whatever its error, and the step is counted as forced
};

/// How a particle is moved. Times are in the units of the solver; 0 means "not given". A
/// displacement crosses a cell once when it reaches the extent of the bounding box of the cell
/// along any axis.
struct IntegratorSettings {
  Method method = Method::dopri5;
  double step = 0.0; ///< fixed: every step (0: 1/4 cell); adaptive: the first step (0: 1/10 cell)
  double tolerance = 1e-6; ///< adaptive: error of the position per unit time, in units of length;
                           ///< never more than a hundredth of the speed
  double min_step = 0.0;   ///< adaptive: a step this small is not given up for a smaller one; see
                           ///< at_min_step. If 0, steps that cross at most min_cells of a cell are
                           ///< taken whatever their error, and counted as forced, since velocities
                           ///< that jump would stop the particle. A step that is cut short for
                           ///< another reason may be smaller: at an end, a face, an exit, or by the
                           ///< size of the cell
  AtMinStep at_min_step = AtMinStep::end;
  double max_step = 0.0;          ///< longest step; 0: one cell. It does not bound a fixed step
                                  ///< that is given
  std::int64_t max_steps = 10000; ///< steps of one particle in one call
  double min_cells = 1e-6;        ///< see min_step

  /// Whether steps end where they reach a face of their cell, up to which they follow the field of
  /// that cell: a piecewise field has a kink at the face, over which no method keeps its order.
  /// Fields without cells have no faces (see advect/integrate/integration.h).
  bool face_aware = false;

  /// A particle leaves (or meets a velocity that is not finite) when a trial point at most this
  /// fraction of a cell away from it does. It ends where a straight line to that point leaves the
  /// mesh, if the field knows that place (as MeshVelocity does), otherwise at its last position
  /// inside.
  double exit_tolerance = 1e-9;

  /// Steady fields only: whether a particle stagnates where its speed is 0, or at most rest_ratio
  /// of the largest speed that it had, or where all the time that is left would move it by less
  /// than rest_cells of a cell. Otherwise a particle at rest waits for the velocity to change.
  bool ends_at_rest = false;
  double rest_ratio = 1e-9;
  double rest_cells = 1e-12;
};

/// One particle on its way.
struct State {
  Vec3d x;
  double time = 0.0;
  double step = 0.0;       ///< step that the controller wants next; 0: none yet
  double length = 0.0;     ///< length of the path
  double peak_speed = 0.0; ///< largest speed so far
  bool fresh = true;       ///< whether the particle was not found inside yet
  int exit_face = -1;      ///< face of its cell through which the particle left; -1: none was found
  Vec3d exit_normal;       ///< unit normal of that face, outwards
};

/// What the integration cost.
struct Work {
  std::int64_t steps = 0;       ///< accepted steps
  std::int64_t rejected = 0;    ///< trials given up for their error, their end or their length
  std::int64_t forced = 0;      ///< steps accepted at the smallest step with an error over the
                                ///< tolerance
  std::int64_t evaluations = 0; ///< evaluations of the velocity

  Work& operator+=(const Work& b) {
    steps += b.steps;
    rejected += b.rejected;
    forced += b.forced;
    evaluations += b.evaluations;
    return *this;
  }
};

} // namespace insitu::advect
