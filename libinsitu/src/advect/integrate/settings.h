#pragma once

#include <cstdint>

#include "math/vec.h"

/// How particles are moved, and what that cost; integrate.h moves them.
namespace insitu::advect {

using math::Vec3d;

enum class Method : std::uint8_t { euler, rk4, bs32, dopri5 };

/// Whether it chooses its steps by their errors; the others have fixed ones.
constexpr bool is_adaptive(Method method) {
  return method == Method::bs32 || method == Method::dopri5;
}

/// What a field is between the steps n - 1 and n, by the values of the steps up to n.
enum class TimeInterpolation : std::uint8_t {
  linear,    ///< the straight line: 2 steps, order 2 in the time between steps
  quadratic, ///< the parabola through the last three: order 3
  cubic ///< Hermite's cubic by slopes at both ends, each that of the parabola through the step and
        ///< the two before it, so that the slope is continuous from interval to interval: 4 steps;
        ///< order 4 where the steps are even, 3 where they are not
};

/// The steps that it takes, the current one included.
constexpr int steps_of(TimeInterpolation interpolation) {
  return int(interpolation) + 2;
}
inline constexpr int most_steps = 4;

/// What becomes of a particle where error control wants steps under a min_step that is given.
enum class AtMinStep : std::uint8_t {
  end, ///< it ends there: INSITU_END_STEP_TOO_SMALL
  take ///< a step that small is taken whatever its error, and counted as forced
};

/// How a particle is moved. Times are in the solver's units; 0 means "not given". A cell is crossed
/// once when a displacement reaches the extent of its bounding box along any axis.
struct IntegratorSettings {
  Method method = Method::dopri5;
  double step = 0.0; ///< fixed: of every step (else 1/4 cell); adaptive: of the first (else 1/10)
  double tolerance = 1e-6; ///< adaptive: error of the position per unit time, in units of length;
                           ///< never more than a hundredth of the speed
  double min_step = 0.0;   ///< adaptive: no step this small is given up for a smaller one, see
                           ///< at_min_step. Else steps that cross at most min_cells of a cell are
                           ///< taken whatever their error, and counted as forced: velocities that
                           ///< jump would stop it. What is cut short elsewise may be smaller: at an
                           ///< end, a face, an exit, or by the cell's size
  AtMinStep at_min_step = AtMinStep::end;
  double max_step = 0.0;          ///< else one cell; not applied to a given fixed step
  std::int64_t max_steps = 10000; ///< of one particle in one call
  double min_cells = 1e-6;        ///< see min_step

  /// Steps end where they reach a face of their cell, up to which its own field is followed: a
  /// piecewise field has a kink there, over which no method keeps its order. Fields without cells
  /// (see advect/integrate/integration.h) have none.
  bool face_aware = false;

  /// A particle leaves (or meets a velocity that is not finite) when a trial point at most this
  /// fraction of a cell away from it does. It ends where a straight line to there leaves the mesh,
  /// if the field knows (as MeshVelocity does), otherwise at its last position inside.
  double exit_tolerance = 1e-9;

  /// Steady fields only: a particle stagnates where its speed is 0, or at most rest_ratio of the
  /// largest it had, or where all the time that is left would move it by less than rest_cells of a
  /// cell. Otherwise a particle at rest waits for the velocity to change.
  bool ends_at_rest = false;
  double rest_ratio = 1e-9;
  double rest_cells = 1e-12;
};

/// One particle on its way.
struct State {
  Vec3d x;
  double time = 0.0;
  double step = 0.0;       ///< that the controller wants next; 0: none yet
  double length = 0.0;     ///< of the path
  double peak_speed = 0.0; ///< largest so far
  bool fresh = true;       ///< not found inside yet
  int exit_face = -1;      ///< of its cell, through which it left, if that was found
  Vec3d exit_normal;       ///< there, unit, outwards
};

/// What the integration cost.
struct Work {
  std::int64_t steps = 0;       ///< accepted
  std::int64_t rejected = 0;    ///< trials given up for their error, their end or their length
  std::int64_t forced = 0;      ///< accepted at the smallest step with an error over the tolerance
  std::int64_t evaluations = 0; ///< of the velocity

  Work& operator+=(const Work& b) {
    steps += b.steps;
    rejected += b.rejected;
    forced += b.forced;
    evaluations += b.evaluations;
    return *this;
  }
};

} // namespace insitu::advect
