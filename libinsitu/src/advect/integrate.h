#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "insitu/insitu.h"

#include "advect/integrators.h"

namespace insitu::advect {

enum class Method : std::uint8_t { rk4, dopri5 };

/// How a particle is moved. Times are in the solver's units; 0 means "not given". A cell is crossed
/// once when a displacement reaches the extent of its bounding box along any axis.
struct IntegratorSettings {
  Method method = Method::dopri5;
  double step = 0.0;       ///< rk4: of every step (else 1/4 cell); dopri5: of the first (else 1/10)
  double tolerance = 1e-6; ///< dopri5: error of the position per unit time, in coordinate units;
                           ///< never more than a hundredth of the speed
  double min_step = 0.0; ///< dopri5: a step this small is taken whatever its error, and counted as
                         ///< forced (else one that crosses at most min_cells of a cell): velocities
                         ///< that jump would stop it
  double max_step = 0.0; ///< else one cell; not applied to a given rk4 step
  std::int64_t max_steps = 10000; ///< of one particle in one call
  double min_cells = 1e-6;        ///< see min_step

  /// A particle leaves (or meets a velocity that is not finite) when a trial point at most this
  /// fraction of a cell away from it does; it ends at its last position inside.
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

/// Moves a particle from p.time until `to` (before p.time: backwards; may be infinite), or until
/// its path is max_length long. visit(p) is called at the start and after every step, except those
/// that only close in on an exit. Returns INSITU_END_ALIVE at `to`, INSITU_END_EXPIRED at
/// max_length, or why it ended. p.x is always a point found inside, unless it was seeded outside or
/// the mesh has moved away from it.
template <VelocityField F, class Visit>
insitu_ending integrate(F& velocity, const IntegratorSettings& settings, double to,
                        double max_length, State& p, Work& work, Visit&& visit);

// ---------------------------------------------------------------------------- implementation

namespace control {
/// The PI controller of Gustafsson (ACM TOMS 17, 1991) for error per unit step, whose order
/// is 4 for the pair 5(4): h_new = h * safety * e_n^(-0.7/4) * e_(n-1)^(0.4/4),
/// e = error / tolerance.
inline constexpr double safety = 0.9;
inline constexpr double exponent = 0.7 / 4;
inline constexpr double previous_exponent = 0.4 / 4;
inline constexpr double largest_growth = 5.0;
inline constexpr double smallest_factor = 0.2;
inline constexpr double least_error = 1e-4; ///< errors below it all count as this
/// Whatever the tolerance, the error stays this fraction of the speed: slow flows, and those that
/// fade towards a stagnation point, are followed too.
inline constexpr double largest_relative_error = 0.01;
/// A bound on the trials for one step: halving from 1e308 to 1e-308 would take 2047.
inline constexpr int max_trials = 4096;

/// The cells, at most, crossed by one step whose size follows from the cell.
inline constexpr double dopri5_cells = 1.0;
inline constexpr double dopri5_first_cells = 0.1;
/// Without an error estimate, rk4 also keeps h |dv| / |dx| of the step before within 1 (it is
/// stable up to 2.8): near a stagnation point steps measured by cells would grow without bound.
inline constexpr double rk4_cells = 0.25;
} // namespace control

/// The cells of this extent that displacement d crosses.
inline double cells_crossed(const Vec3d& d, const Vec3d& extent) {
  return std::max({std::abs(d.x) / extent.x, std::abs(d.y) / extent.y, std::abs(d.z) / extent.z});
}

template <VelocityField F, class Visit>
insitu_ending integrate(F& velocity, const IntegratorSettings& settings, double to,
                        double max_length, State& p, Work& work, Visit&& visit) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  const bool adaptive = settings.method == Method::dopri5;
  const double from = p.time;
  const double direction = to < from ? -1.0 : 1.0;
  const double span = std::abs(to - from);

  Vec3d k1;
  ++work.evaluations;
  if (const Sampled first = velocity(p.x, from, k1); first != Sampled::inside) {
    return first == Sampled::not_finite ? INSITU_END_NOT_FINITE
           : p.fresh                    ? INSITU_END_SEED_OUTSIDE
                                        : INSITU_END_LEFT;
  }
  velocity.accepted();
  p.fresh = false;
  visit(p);

  // Time is kept relative to the start, where tiny steps still count.
  double elapsed = 0.0;
  double previous_error = 1.0;
  double rate_limit = infinity;
  std::int64_t steps = 0;
  // After an obstacle, steps are halved until it is within exit_tolerance; only two steps of one
  // size in a row say that there is a way past it.
  int closing_in = 0;
  while (elapsed < span) {
    // A field may change its coordinates between steps (over a pole).
    if constexpr (requires { velocity.settle(p.x, k1); })
      velocity.settle(p.x, k1);
    const double speed = measure(velocity, p.x, k1);
    const double remaining = span - elapsed;
    const Vec3d extent = velocity.extent();
    const double cells_per_time = cells_crossed(k1, extent);
    p.peak_speed = std::max(p.peak_speed, speed);
    if (!std::isfinite(speed))
      return INSITU_END_NOT_FINITE;
    if (speed == 0.0 && span == infinity)
      return INSITU_END_STAGNATED; // nothing to wait for
    if (settings.ends_at_rest && (speed == 0.0 || speed <= settings.rest_ratio * p.peak_speed ||
                                  (std::isfinite(remaining) && extent.x < infinity &&
                                   cells_per_time * remaining <= settings.rest_cells)))
      return INSITU_END_STAGNATED;
    const double length_left = max_length - p.length;
    if (std::isfinite(max_length) && length_left <= 1e-12 * max_length)
      return INSITU_END_EXPIRED;
    if (steps == settings.max_steps)
      return INSITU_END_STEP_LIMIT;

    // What the step should be, and what it may be.
    const double cell_time = cells_per_time > 0.0 ? 1.0 / cells_per_time : infinity;
    const double cells = adaptive ? control::dopri5_cells : control::rk4_cells;
    const bool by_cell =
        adaptive ? settings.max_step == 0.0 : settings.step == 0.0 && settings.max_step == 0.0;
    double limit = by_cell ? std::min(cells * cell_time, rate_limit) : infinity;
    if (settings.max_step > 0.0 && (adaptive || settings.step == 0.0))
      limit = settings.max_step;
    double wanted = p.step;
    if (closing_in == 0 && !adaptive)
      wanted = settings.step > 0.0 ? settings.step : limit;
    else if (wanted == 0.0)
      wanted = settings.step > 0.0 ? settings.step
               : by_cell           ? control::dopri5_first_cells * cell_time
                                   : limit;
    if (!std::isfinite(
            wanted)) // no cells: a hundredth of the time, or of the distance to the origin
      wanted = speed == 0.0          ? remaining
               : std::isfinite(span) ? 0.01 * span
                                     : (length_of(p.x) + 1.0) / speed * 0.01;
    double h = std::min({wanted, limit, remaining});
    if (speed > 0.0)
      h = std::min(h, length_left / speed);
    const bool cut = h < wanted;

    // Trials until one is accepted.
    const double t = from + direction * elapsed;
    bool retried = false, forced = false;
    double relative_error = control::least_error;
    double chord = 0.0;
    Trial trial;
    for (int trials = 0;; ++trials) {
      if (trials == control::max_trials)
        return INSITU_END_STAGNATED;
      trial = adaptive ? dopri5_step(velocity, p.x, t, direction * h, k1)
                       : rk4_step(velocity, p.x, t, direction * h, k1);
      work.evaluations += adaptive ? 6 : 4;
      const Vec3d moved = trial.x - p.x;
      double factor = 1.0;
      if (trial.sampled != Sampled::inside) {
        // Time counts too: a moving mesh can leave a particle that is at rest.
        const bool close = cells_crossed(moved, extent) <= settings.exit_tolerance &&
                           (span == infinity || h <= settings.exit_tolerance * span);
        if (close || 0.5 * h == 0.0)
          return trial.sampled == Sampled::outside ? INSITU_END_LEFT : INSITU_END_NOT_FINITE;
        closing_in = 2;
        factor = 0.5;
      } else if (const double crossed = by_cell ? cells_crossed(moved, extent) : 0.0;
                 crossed > 2.0 * cells) {
        factor = std::max(cells / crossed, 1e-3); // the velocity grew within the step
      } else if (chord = measure(velocity, p.x, moved); chord > length_left * (1.0 + 1e-12)) {
        factor = std::min(length_left / chord, 1.0 - 1e-12);
      } else if (adaptive) {
        const double fastest = std::max(speed, measure(velocity, trial.x, trial.v));
        const double tolerance =
            std::max(std::min(settings.tolerance, control::largest_relative_error * fastest),
                     16.0 * epsilon * fastest);
        relative_error = trial.error == 0.0
                             ? control::least_error
                             : std::max(trial.error / tolerance, control::least_error);
        const bool smallest = settings.min_step > 0.0 ? h <= settings.min_step
                              : extent.x < infinity
                                  ? cells_crossed(moved, extent) <= settings.min_cells
                                  : std::isfinite(span) && h <= 1e-12 * span;
        forced = relative_error > 1.0 && smallest;
        if (relative_error > 1.0 && !forced)
          factor = std::max({control::smallest_factor,
                             control::safety * std::pow(relative_error, -1.0 / 4),
                             settings.min_step / h});
      }
      if (factor == 1.0)
        break;
      ++work.rejected;
      retried = true;
      h *= factor;
    }

    // The step is accepted.
    velocity.accepted();
    ++work.steps;
    work.forced += forced;
    elapsed = h == remaining ? span : elapsed + h;
    p.x = trial.x;
    p.length += chord;
    p.time = elapsed == span ? to : from + direction * elapsed;
    if (const double change = measure(velocity, p.x, trial.v - k1); !adaptive && change > 0.0)
      rate_limit = std::max(chord / change, 1e-3 * h);
    k1 = trial.v;
    if (closing_in > 0) {
      p.step = h;
      steps += --closing_in == 0;
    } else {
      ++steps;
      if (adaptive) {
        double factor = control::safety * std::pow(relative_error, -control::exponent) *
                        std::pow(previous_error, control::previous_exponent);
        factor =
            std::clamp(factor, control::smallest_factor, retried ? 1.0 : control::largest_growth);
        if (forced) { // past the jump: its error says nothing about what follows
          factor = control::largest_growth;
          relative_error = 1.0;
        }
        // A step that was cut short says little about the one that was wanted.
        p.step = cut && !retried ? std::max(wanted, h * factor) : h * factor;
        previous_error = relative_error;
      }
      visit(p);
    }
  }
  return INSITU_END_ALIVE;
}

} // namespace insitu::advect
