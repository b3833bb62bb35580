#pragma once

#include "advect/integrate.h"

/// The implementation of integrate(), included by its header alone.
namespace insitu::advect {

/// A field of cells, each with a formula of its own, for steps that end at faces. confine(x, w, t)
/// chooses the cell into which a particle at x goes in direction w: until release(), that cell's
/// formula answers, also some way beyond its faces, and points too far beyond are outside.
/// depth(x, t) is how far within that cell a point lies, negative outside, in parametric units;
/// last_depth() is that of the point asked last. cross(x, w, t) chooses the next cell, where a
/// particle comes to a face.
enum class Crossed : std::uint8_t { into_next, to_boundary, nowhere };
template <class F>
concept CellwiseField = requires(F& f, const Vec3d& x, double t) {
  { f.confine(x, x, t) } -> std::same_as<bool>;
  f.release();
  { f.depth(x, t) } -> std::same_as<double>;
  { f.last_depth() } -> std::same_as<double>;
  { f.cross(x, x, t) } -> std::same_as<Crossed>;
};

/// A field that knows where its domain ends: leave(a, b, t, dt), with a the particle's place, is
/// where the segment leaves it, travelled from t to t + dt: contextually false, or with t (in
/// [0, 1]), inside (a point in the domain, on the boundary to rounding), face and normal. The
/// particle's place is then that point. It may tell by way_out(a, b, t) at what part of the
/// segment that is, or a negative number, and change nothing.
template <class F>
concept ExitingField = requires(F& f, const Vec3d& x, double t) {
  { f.leave(x, x, t, t)->inside } -> std::convertible_to<Vec3d>;
  { f.leave(x, x, t, t)->t } -> std::convertible_to<double>;
};

namespace control {
/// The PI controller of Gustafsson (ACM TOMS 17, 1991) for error per unit step, which falls as h^q:
/// h_new = h * safety * e_n^(-0.7/q) * e_(n-1)^(0.4/q), e = error / tolerance.
inline constexpr double safety = 0.9;
inline constexpr double exponent = 0.7;
inline constexpr double previous_exponent = 0.4;
inline constexpr double largest_growth = 5.0;
inline constexpr double smallest_factor = 0.2;
inline constexpr double least_error = 1e-4; ///< errors below it all count as this
/// Whatever the tolerance, the error stays this fraction of the speed: slow flows, and those that
/// fade towards a stagnation point, are followed too.
inline constexpr double largest_relative_error = 0.01;
/// A bound on the trials for one step: halving from 1e308 to 1e-308 would take 2047.
inline constexpr int max_trials = 4096;

/// The cells crossed by the first step of an adaptive method. (Those of the others: Method::cells.
/// Without an error estimate, fixed methods also keep h |dv| / |dx| of the step before within 1
/// (rk4 is stable up to 2.8): near a stagnation point steps measured by cells would grow without
/// bound.)
inline constexpr double first_cells = 0.1;

/// A step that ends this deep within its cell, or less far outside, ends on its face.
inline constexpr double on_face = 1e-9;
inline constexpr int most_landings = 12; ///< trials for one face
/// So many faces in a row without a way in between: velocities push onto an edge, or from both
/// sides onto a face. Then a step is taken as if there were no faces.
inline constexpr int most_idle_faces = 6;
} // namespace control

/// The cells of this extent that displacement d crosses.
inline double cells_crossed(const Vec3d& d, const Vec3d& extent) {
  return std::max({std::abs(d.x) / extent.x, std::abs(d.y) / extent.y, std::abs(d.z) / extent.z});
}

/// integrate() by one method.
template <class M, VelocityField F, class Visit>
class Integration {
public:
  Integration(F& velocity, const IntegratorSettings& settings, double to, double max_length,
              State& p, Work& work, Visit& visit)
      : velocity_(velocity), s_(settings), to_(to), max_length_(max_length), p_(p), work_(work),
        visit_(visit), from_(p.time), direction_(to < p.time ? -1.0 : 1.0),
        span_(std::abs(to - p.time)),
        by_cell_(M::adaptive ? s_.max_step == 0.0 : s_.step == 0.0 && s_.max_step == 0.0) {}

  insitu_ending run() {
    ++work_.evaluations;
    if (const Sampled first = velocity_(p_.x, from_, k1_); first != Sampled::inside) {
      return first == Sampled::not_finite ? INSITU_END_NOT_FINITE
             : p_.fresh                   ? INSITU_END_SEED_OUTSIDE
                                          : INSITU_END_LEFT;
    }
    velocity_.accepted();
    p_.fresh = false;
    visit_(p_);
    insitu_ending ending = INSITU_END_COUNT;
    while (elapsed_ < span_ && ending == INSITU_END_COUNT) {
      // A field may change its coordinates between steps (over a pole); a rate goes along.
      if constexpr (requires { velocity_.settle(p_.x, k1_); })
        velocity_.settle(p_.x, k1_);
      confine();
      plan();
      ending = stops();
      if (ending == INSITU_END_COUNT)
        ending = advance();
    }
    release(true);
    return ending == INSITU_END_COUNT ? INSITU_END_ALIVE : ending;
  }

private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  double time() const { return from_ + direction_ * elapsed_; }
  void plan();
  insitu_ending stops() const;
  insitu_ending advance();
  insitu_ending give_up(const Trial& trial, double h, double& factor);
  bool exit(const Vec3d& b, double dt);
  void accept(const Trial& trial, double h, bool forced, bool retried);

  // Steps that end at faces.
  enum class Landing : std::uint8_t { none, on_face, again, idle };
  struct Bracket {
    double inside = 0.0, outside = infinity; ///< steps
    int landings = 0;
  };
  void confine();
  void release(bool finally);
  Landing land(const Trial& trial, double& h, Bracket& bracket);
  double way_to_face(const DenseStep& path, double low, double high);
  bool cuts_corner(const Trial& trial, double& h, Bracket& bracket);
  bool idle_face();

  F& velocity_;
  const IntegratorSettings& s_;
  double to_, max_length_;
  State& p_;
  Work& work_;
  Visit& visit_;
  const double from_, direction_, span_;
  const bool by_cell_;

  Vec3d k1_; ///< the velocity at p
  // Time is kept relative to the start, where tiny steps still count.
  double elapsed_ = 0.0;
  double previous_error_ = 1.0;
  double rate_limit_ = infinity;
  std::int64_t steps_ = 0;
  // After an obstacle, steps are halved until it is within exit_tolerance; only two steps of one
  // size in a row say that there is a way past it.
  int closing_in_ = 0;
  bool closely_ = false; ///< until rounding: the mesh moves over the particle

  // Of the next step.
  double speed_ = 0.0, remaining_ = 0.0, cells_per_time_ = 0.0, length_left_ = 0.0;
  Vec3d extent_;
  double wanted_ = 0.0, h_ = 0.0;
  double relative_error_ = 0.0, chord_ = 0.0;

  bool confined_ = false; ///< to one cell
  bool entered_ = false;  ///< it just now: k1 is another cell's
  int free_steps_ = 0;    ///< without faces
  int idle_faces_ = 0;    ///< in a row
};

/// What the step should be, and what it may be.
template <class M, VelocityField F, class Visit>
void Integration<M, F, Visit>::plan() {
  speed_ = measure(velocity_, p_.x, k1_);
  remaining_ = span_ - elapsed_;
  extent_ = velocity_.extent();
  cells_per_time_ = cells_crossed(k1_, extent_);
  p_.peak_speed = std::max(p_.peak_speed, speed_);
  length_left_ = max_length_ - p_.length;

  const double cell_time = cells_per_time_ > 0.0 ? 1.0 / cells_per_time_ : infinity;
  double limit = by_cell_ ? std::min(M::cells * cell_time, rate_limit_) : infinity;
  if (s_.max_step > 0.0 && (M::adaptive || s_.step == 0.0))
    limit = s_.max_step;
  wanted_ = p_.step;
  if (closing_in_ == 0 && !M::adaptive)
    wanted_ = s_.step > 0.0 ? s_.step : limit;
  else if (wanted_ == 0.0)
    wanted_ = s_.step > 0.0 ? s_.step : by_cell_ ? control::first_cells * cell_time : limit;
  if (!std::isfinite(
          wanted_)) // no cells: a hundredth of the time, or of the distance to the origin
    wanted_ = speed_ == 0.0          ? remaining_
              : std::isfinite(span_) ? 0.01 * span_
                                     : (length_of(p_.x) + 1.0) / speed_ * 0.01;
  h_ = std::min({wanted_, limit, remaining_});
  if (speed_ > 0.0)
    h_ = std::min(h_, length_left_ / speed_);
  if (confined_)
    h_ = std::min(h_, cell_time);
}

template <class M, VelocityField F, class Visit>
insitu_ending Integration<M, F, Visit>::stops() const {
  if (!std::isfinite(speed_))
    return INSITU_END_NOT_FINITE;
  if (speed_ == 0.0 && span_ == infinity)
    return INSITU_END_STAGNATED; // nothing to wait for
  if (s_.ends_at_rest && (speed_ == 0.0 || speed_ <= s_.rest_ratio * p_.peak_speed ||
                          (std::isfinite(remaining_) && extent_.x < infinity &&
                           cells_per_time_ * remaining_ <= s_.rest_cells)))
    return INSITU_END_STAGNATED;
  if (std::isfinite(max_length_) && length_left_ <= 1e-12 * max_length_)
    return INSITU_END_EXPIRED;
  if (steps_ == s_.max_steps)
    return INSITU_END_STEP_LIMIT;
  return INSITU_END_COUNT;
}

/// Trials until one is accepted; INSITU_END_COUNT: one was.
template <class M, VelocityField F, class Visit>
insitu_ending Integration<M, F, Visit>::advance() {
  const double t = time();
  bool retried = false, forced = false;
  double h = h_;
  relative_error_ = control::least_error;
  Trial trial;
  Bracket bracket;
  for (int trials = 0;; ++trials) {
    if (trials == control::max_trials)
      return INSITU_END_STAGNATED;
    trial = M::step(velocity_, p_.x, t, direction_ * h, k1_);
    work_.evaluations += M::evaluations;
    const Vec3d moved = trial.x - p_.x;
    double factor = 1.0;
    if (trial.sampled != Sampled::inside) {
      if (confined_ && trial.sampled == Sampled::outside) {
        // Too far beyond the cell; the way to its face is shorter.
        bracket.outside = std::min(bracket.outside, h);
        if (cells_crossed(h * k1_, extent_) < 1e-9)
          release(false);
        factor = 0.5;
      } else {
        factor = retried ? 0.5 : 1.0;
        const insitu_ending ending = give_up(trial, h, factor);
        if (ending != INSITU_END_COUNT)
          return ending;
      }
    } else if (const double crossed = by_cell_ ? cells_crossed(moved, extent_) : 0.0;
               crossed > 2.0 * M::cells) {
      factor = std::max(M::cells / crossed, 1e-3); // the velocity grew within the step
    } else if (chord_ = measure(velocity_, p_.x, moved); chord_ > length_left_ * (1.0 + 1e-12)) {
      factor = std::min(length_left_ / chord_, 1.0 - 1e-12);
    } else if (M::adaptive) {
      const double fastest = std::max(speed_, measure(velocity_, p_.x, trial.v));
      const double tolerance =
          std::max(std::min(s_.tolerance, control::largest_relative_error * fastest),
                   16.0 * epsilon * fastest);
      const double error = measure(velocity_, p_.x, trial.error);
      relative_error_ =
          error == 0.0 ? control::least_error : std::max(error / tolerance, control::least_error);
      const bool smallest = s_.min_step > 0.0      ? h <= s_.min_step
                            : extent_.x < infinity ? cells_crossed(moved, extent_) <= s_.min_cells
                                                   : std::isfinite(span_) && h <= 1e-12 * span_;
      forced = relative_error_ > 1.0 && smallest;
      if (relative_error_ > 1.0 && !forced)
        factor = std::max({control::smallest_factor,
                           control::safety * std::pow(relative_error_, -1.0 / M::error_order),
                           s_.min_step / h});
    }
    if (factor == 1.0) {
      Landing landing = Landing::none;
      if constexpr (CellwiseField<F>)
        if (confined_)
          landing = land(trial, h, bracket);
      if (landing == Landing::none || landing == Landing::on_face) {
        accept(trial, h, forced, retried);
        return INSITU_END_COUNT;
      }
      if (landing == Landing::idle)
        return INSITU_END_COUNT;
      ++work_.rejected; // but not for its error: the next step need not shrink
      continue;
    }
    ++work_.rejected;
    retried = true;
    h *= factor;
  }
}

/// A stage of the trial was not inside. INSITU_END_COUNT: `factor` of the step may be.
template <class M, VelocityField F, class Visit>
insitu_ending Integration<M, F, Visit>::give_up(const Trial& trial, double h, double& factor) {
  const double tolerance = closely_ ? 4.0 * epsilon : s_.exit_tolerance;
  // Far from the origin coordinates may be coarser than the tolerance.
  const double coarse = 8.0 * epsilon * cells_crossed(p_.x, {1.0, 1.0, 1.0});
  // Time counts too: a moving mesh can leave a particle that is at rest.
  const auto close = [&](const Vec3d& way, double time) {
    return (cells_crossed(way, extent_) <= tolerance ||
            cells_crossed(way, {1.0, 1.0, 1.0}) <= coarse) &&
           (span_ == infinity || time <= tolerance * span_);
  };
  const bool left = trial.sampled == Sampled::outside;
  closing_in_ = 2;
  if constexpr (requires { velocity_.way_out(p_.x, p_.x, h); }) {
    // The part of the step, straight on, that stays inside, but for what the path may be curved. It
    // is tried once a step; then halves.
    const Vec3d straight = (direction_ * h) * k1_;
    if (left && factor == 1.0 && !closely_ && std::isfinite(cells_crossed(straight, extent_))) {
      const double part = velocity_.way_out(p_.x, p_.x + straight, time());
      if (part >= 0.0 && close(part * straight, part * h) && exit(p_.x + straight, h))
        return INSITU_END_LEFT;
      if (part > 0.0 && part < 1.0) {
        const double curved = std::clamp(0.1 * part * cells_crossed(straight, extent_), 1e-4, 0.1);
        factor = (1.0 - curved) * part;
        return INSITU_END_COUNT;
      }
    }
  }
  factor = 0.5;
  const Vec3d moved = trial.x - p_.x;
  if (!close(moved, h) && 0.5 * h != 0.0)
    return INSITU_END_COUNT;
  if (!left)
    return INSITU_END_NOT_FINITE;
  if constexpr (ExitingField<F>) {
    const double dt = speed_ > 0.0 ? std::min(measure(velocity_, p_.x, moved) / speed_, h) : h;
    if (!exit(trial.x, dt) && !closely_) {
      closely_ = true;
      return INSITU_END_COUNT;
    }
  }
  return INSITU_END_LEFT;
}

/// Places the particle where the way to b, which takes dt, leaves the domain, if it does.
template <class M, VelocityField F, class Visit>
bool Integration<M, F, Visit>::exit(const Vec3d& b, double dt) {
  if constexpr (ExitingField<F>) {
    if (const auto exit = velocity_.leave(p_.x, b, time(), direction_ * dt)) {
      p_.length += measure(velocity_, p_.x, exit->inside - p_.x);
      p_.time = time() + direction_ * exit->t * dt;
      p_.x = exit->inside;
      p_.exit_face = exit->face;
      p_.exit_normal = exit->normal;
      return true;
    }
  }
  return false;
}

template <class M, VelocityField F, class Visit>
void Integration<M, F, Visit>::accept(const Trial& trial, double h, bool forced, bool retried) {
  constexpr bool dense = std::invocable<Visit&, const State&, const DenseStep&>;
  const double t = time();
  const Vec3d from = p_.x, before = k1_;
  const bool cut = h < wanted_;
  velocity_.accepted();
  ++work_.steps;
  work_.forced += forced;
  elapsed_ = h == remaining_ ? span_ : elapsed_ + h;
  p_.x = trial.x;
  p_.length += chord_;
  p_.time = elapsed_ == span_ ? to_ : time();
  if (!M::adaptive)
    if (const double change = measure(velocity_, from, trial.v - before); change > 0.0)
      rate_limit_ = std::max(chord_ / change, 1e-3 * h);
  k1_ = trial.v;
  const bool closing_in = closing_in_ > 0;
  if (closing_in) {
    p_.step = h;
    steps_ += --closing_in_ == 0;
  } else {
    ++steps_;
    free_steps_ -= free_steps_ > 0;
    if (M::adaptive) {
      double factor = control::safety *
                      std::pow(relative_error_, -control::exponent / M::error_order) *
                      std::pow(previous_error_, control::previous_exponent / M::error_order);
      factor =
          std::clamp(factor, control::smallest_factor, retried ? 1.0 : control::largest_growth);
      if (forced) { // past the jump: its error says nothing about what follows
        factor = control::largest_growth;
        relative_error_ = 1.0;
      }
      // A step that was cut short says little about the one that was wanted.
      p_.step = cut && !retried ? std::max(wanted_, h * factor) : h * factor;
      previous_error_ = relative_error_;
    }
  }
  if constexpr (dense)
    visit_(static_cast<const State&>(p_),
           DenseStep(from, t, direction_ * h, before, trial, M::quintic));
  else if (!closing_in)
    visit_(static_cast<const State&>(p_));
}

// ------------------------------------------------------------------------------ faces

template <VelocityField F, class Visit>
insitu_ending integrate(F& velocity, const IntegratorSettings& settings, double to,
                        double max_length, State& p, Work& work, Visit&& visit) {
  switch (settings.method) {
  case Method::euler:
    return Integration<Euler, F, Visit>(velocity, settings, to, max_length, p, work, visit).run();
  case Method::rk4:
    return Integration<Rk4, F, Visit>(velocity, settings, to, max_length, p, work, visit).run();
  case Method::bs32:
    return Integration<Bs32, F, Visit>(velocity, settings, to, max_length, p, work, visit).run();
  default:
    return Integration<Dopri5, F, Visit>(velocity, settings, to, max_length, p, work, visit).run();
  }
}

} // namespace insitu::advect

#include "advect/integration_faces.h"
