#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

#include "insitu/insitu.h"

#include "advect/integrate/control.h"
#include "advect/integrate/dense.h"
#include "advect/integrate/fields.h"
#include "advect/integrate/integrators.h"
#include "advect/integrate/kept_steps.h"
#include "advect/integrate/settings.h"

/// What integrate() and integration() decide between the velocities they ask for; included by
/// integrate.h alone.
namespace insitu::advect {

/// What integration() knows between two velocities, by one method.
template <class M, VelocityField F, class Visit>
class Integration {
public:
  Integration(F& velocity, const IntegratorSettings& settings, double to, double max_length,
              State& p, Work& work, Visit& visit)
      : velocity_(velocity), s_(settings), to_(to), max_length_(max_length), p_(p), work_(work),
        visit_(visit), from_(p.time), direction_(to < p.time ? -1.0 : 1.0),
        span_(std::abs(to - p.time)),
        by_cell_(M::adaptive ? s_.max_step == 0.0 : s_.step == 0.0 && s_.max_step == 0.0) {}

  /// What all that follows depends on, between two steps, but for the arguments of the constructor;
  /// and an integration that goes on from there, to the bit, with the same `to`.
  KeptSteps keep() const {
    return {from_,           direction_,  span_,     k1_,         elapsed_,
            previous_error_, rate_limit_, steps_,    closing_in_, closely_,
            free_steps_,     idle_faces_, confined_, entered_,    told_to_end_};
  }
  void go_on_from(const KeptSteps& k) {
    from_ = k.from;
    direction_ = k.direction;
    span_ = k.span;
    k1_ = k.k1;
    elapsed_ = k.elapsed;
    previous_error_ = k.previous_error;
    rate_limit_ = k.rate_limit;
    steps_ = k.steps;
    closing_in_ = k.closing_in;
    closely_ = k.closely;
    free_steps_ = k.free_steps;
    idle_faces_ = k.idle_faces;
    confined_ = k.confined;
    entered_ = k.entered;
    told_to_end_ = k.told_to_end;
  }

  double time() const { return from_ + direction_ * elapsed_; }
  bool at_end() const { return !(elapsed_ < span_); }

  /// With the velocity at the particle: INSITU_END_COUNT, or how it ends at once.
  insitu_ending begin(Sampled first, const Vec3d& v);

  /// Before a step: true if the velocity is wanted again, now that of one cell, for confined().
  bool confine();
  void confined(Sampled sampled, const Vec3d& v);

  /// Plans the step; INSITU_END_COUNT: there is one.
  insitu_ending plan() {
    choose_step();
    return stops();
  }

  // Of a trial.
  const Vec3d& k1() const { return k1_; }
  double h() const { return direction_ * h_; }
  /// What is made of it: another is wanted, of h(); or the step is done, or given up for the next;
  /// or the particle ends as ending() says; or the trial, which may have become shorter, ends on a
  /// face, and the next cell there, in direction way(), is wanted for enter().
  enum class Verdict : std::uint8_t { again, done, ends, crosses };
  Verdict judge(Trial& trial);
  Vec3d way(const Trial& trial) const { return direction_ * trial.v; }
  double end_time() const { return time() + direction_ * h_; }
  Verdict enter(Crossed crossed, Trial& trial);
  insitu_ending ending() const { return ending_; }

  /// At the end: true if the velocity is wanted again, for its owner's cell, and released().
  bool finish();
  void released(Sampled sampled) {
    if (sampled == Sampled::inside) {
      ++work_.evaluations;
      velocity_.accepted();
    }
  }

private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  static constexpr bool visitor_ends =
      std::is_same_v<std::invoke_result_t<Visit&, const State&>, bool>;

  template <class... Path>
  void tell(const Path&... path) {
    if constexpr (visitor_ends)
      told_to_end_ = !visit_(static_cast<const State&>(p_), path...);
    else
      visit_(static_cast<const State&>(p_), path...);
  }

  Verdict another();
  void choose_step();
  insitu_ending stops() const;
  bool is_close(const Vec3d& way, double time) const;
  bool is_close(const Vec3d& way, double time, double tolerance) const;
  bool creeps(const Trial& trial);
  bool give_up(const Trial& trial, double& factor);
  double growth_allowed(const Trial& trial);
  bool exit(const Vec3d& b, double dt);
  void accept(Trial& trial);
  template <class... Time>
  Vec3d kept_inside(const Vec3d& x, Time... time) {
    if constexpr (requires { velocity_.kept_inside(x, time...); })
      return velocity_.kept_inside(x, time...);
    return x;
  }
  DenseStep path_of(const Trial& trial) const {
    return {p_.x, time(), direction_ * h_, k1_, trial, M::quintic};
  }

  // Steps that end at faces.
  enum class Landing : std::uint8_t { inside, at_face, again, idle };
  struct Bracket {
    double inside = 0.0, outside = infinity; ///< steps
    int landings = 0;
  };
  void release();
  bool is_beyond_face();
  Landing land(Trial& trial);
  Landing land_along(Trial& trial);
  double way_to_face(const DenseStep& path, double low, double high, double outside);
  bool cuts_corner(const Trial& trial);
  bool idle_face();

  F& velocity_;
  const IntegratorSettings& s_;
  double to_, max_length_;
  State& p_;
  Work& work_;
  Visit& visit_;
  double from_, direction_, span_;
  const bool by_cell_;

  Vec3d k1_; ///< the velocity at p
  // Time is kept relative to the start, where tiny steps still count.
  double elapsed_ = 0.0;
  double previous_error_ = 1.0;
  double rate_limit_ = infinity;
  std::int64_t steps_ = 0;
  insitu_ending ending_ = INSITU_END_COUNT;
  // After an obstacle, steps are halved until it is within exit_tolerance; only two steps of one
  // size in a row say that there is a way past it.
  int closing_in_ = 0;
  bool closely_ = false; ///< until rounding: the mesh moves over the particle

  // Of the next step.
  double speed_ = 0.0, remaining_ = 0.0, cells_per_time_ = 0.0, length_left_ = 0.0;
  Vec3d extent_;
  double wanted_ = 0.0, h_ = 0.0; ///< h_: of the next trial
  int trials_ = 0;
  bool retried_ = false, forced_ = false;
  double relative_error_ = 0.0, chord_ = 0.0;
  Bracket bracket_;
  std::optional<DenseStep> landed_; ///< the step came to its face along this

  bool confined_ = false; ///< to one cell
  bool entered_ = false;  ///< it just now: k1 is another cell's
  int free_steps_ = 0;    ///< without faces
  int idle_faces_ = 0;    ///< in a row

  bool told_to_end_ = false; ///< by the visitor
};

template <class M, VelocityField F, class Visit>
insitu_ending Integration<M, F, Visit>::begin(Sampled first, const Vec3d& v) {
  ++work_.evaluations;
  if (first != Sampled::inside)
    return first == Sampled::not_finite ? INSITU_END_NOT_FINITE
           : p_.fresh                   ? INSITU_END_SEED_OUTSIDE
                                        : INSITU_END_LEFT;
  k1_ = v;
  velocity_.accepted();
  p_.x = kept_inside(p_.x);
  p_.fresh = false;
  tell();
  return INSITU_END_COUNT;
}

/// What the step should be, and what it may be.
template <class M, VelocityField F, class Visit>
void Integration<M, F, Visit>::choose_step() {
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
  trials_ = 0;
  retried_ = forced_ = false;
  relative_error_ = control::least_error;
  bracket_ = {};
  landed_.reset();
}

template <class M, VelocityField F, class Visit>
insitu_ending Integration<M, F, Visit>::stops() const {
  if constexpr (visitor_ends)
    if (told_to_end_)
      return INSITU_END_REMOVED;
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

template <class M, VelocityField F, class Visit>
typename Integration<M, F, Visit>::Verdict Integration<M, F, Visit>::judge(Trial& trial) {
  work_.evaluations += M::evaluations;
  ending_ = INSITU_END_COUNT;
  double factor = 1.0; // of the next trial's step; 1: this one may be accepted
  if (trial.sampled == Sampled::inside && creeps(trial))
    trial.sampled = Sampled::outside;
  if (trial.sampled == Sampled::inside) {
    factor = growth_allowed(trial);
    if (ending_ != INSITU_END_COUNT) {
      ++work_.rejected;
      return Verdict::ends;
    }
  } else if (confined_ && trial.sampled == Sampled::outside) {
    // Too far beyond the cell; the way to its face is shorter.
    bracket_.outside = std::min(bracket_.outside, h_);
    if (cells_crossed(h_ * k1_, extent_) < 1e-9)
      release();
    factor = 0.5;
  } else {
    factor = retried_ ? 0.5 : 1.0;
    if (give_up(trial, factor))
      return Verdict::ends;
  }
  if (factor < 1.0) {
    ++work_.rejected;
    retried_ = true;
    h_ *= factor;
    return another();
  }
  if constexpr (CellwiseField<F>)
    if (confined_)
      switch (land(trial)) {
      case Landing::inside:
        break;
      case Landing::at_face:
        return Verdict::crosses;
      case Landing::idle:
        return Verdict::done;
      case Landing::again:
        ++work_.rejected; // but not for its error: the next step need not shrink
        return another();
      }
  accept(trial);
  return Verdict::done;
}

template <class M, VelocityField F, class Visit>
typename Integration<M, F, Visit>::Verdict Integration<M, F, Visit>::another() {
  if (++trials_ < control::max_trials)
    return Verdict::again;
  ending_ = INSITU_END_STAGNATED;
  return Verdict::ends;
}

/// 1 if the trial, all inside, may be accepted, or ends the particle, as ending_ says; otherwise
/// the factor by which its step is too long.
template <class M, VelocityField F, class Visit>
double Integration<M, F, Visit>::growth_allowed(const Trial& trial) {
  const Vec3d moved = trial.x - p_.x;
  if (by_cell_)
    if (const double crossed = cells_crossed(moved, extent_); crossed > 2.0 * M::cells)
      return std::max(M::cells / crossed, 1e-3); // the velocity grew within the step
  chord_ = measure(velocity_, p_.x, moved);
  if (chord_ > length_left_ * (1.0 + 1e-12))
    return std::min(length_left_ / chord_, 1.0 - 1e-12);
  if constexpr (M::adaptive) {
    const double fastest = std::max(speed_, measure(velocity_, p_.x, trial.v));
    const double tolerance =
        std::max(std::min(s_.tolerance, control::largest_relative_error * fastest),
                 16.0 * epsilon * fastest);
    const double error = measure(velocity_, p_.x, trial.error);
    relative_error_ =
        error == 0.0 ? control::least_error : std::max(error / tolerance, control::least_error);
    const bool smallest = s_.min_step > 0.0      ? h_ <= s_.min_step
                          : extent_.x < infinity ? cells_crossed(moved, extent_) <= s_.min_cells
                                                 : std::isfinite(span_) && h_ <= 1e-12 * span_;
    forced_ = relative_error_ > 1.0 && smallest;
    if (forced_ && s_.min_step > 0.0 && s_.at_min_step == AtMinStep::end && !is_beyond_face()) {
      ending_ = INSITU_END_STEP_TOO_SMALL;
      return 1.0;
    }
    if (relative_error_ > 1.0 && !forced_)
      return std::max({control::smallest_factor,
                       control::safety * std::pow(relative_error_, -1.0 / M::error_order),
                       s_.min_step / h_});
  }
  return 1.0;
}

template <class M, VelocityField F, class Visit>
void Integration<M, F, Visit>::accept(Trial& trial) {
  const double h = h_;
  constexpr bool dense = std::invocable<Visit&, const State&, const DenseStep&>;
  const double t = time();
  const Vec3d from = p_.x, before = k1_;
  const bool cut = h < wanted_;
  velocity_.accepted();
  trial.x = h == remaining_ ? kept_inside(trial.x, to_) : kept_inside(trial.x);
  ++work_.steps;
  work_.forced += forced_;
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
    if (--closing_in_ == 0) { // past it, or on a wall that it does not cross: there steps may grow
      ++steps_;
      free_steps_ = std::max(free_steps_, 1);
    }
  } else {
    ++steps_;
    free_steps_ -= free_steps_ > 0;
    if (M::adaptive) {
      double factor = control::safety *
                      std::pow(relative_error_, -control::exponent / M::error_order) *
                      std::pow(previous_error_, control::previous_exponent / M::error_order);
      factor =
          std::clamp(factor, control::smallest_factor, retried_ ? 1.0 : control::largest_growth);
      if (forced_) { // past the jump: its error says nothing about what follows
        factor = control::largest_growth;
        relative_error_ = 1.0;
      }
      // A step that was cut short says little about the one that was wanted.
      p_.step = cut && !retried_ ? std::max(wanted_, h * factor) : h * factor;
      previous_error_ = relative_error_;
    }
  }
  if (dense && visit_.is_dense())
    tell(landed_ ? *landed_ : DenseStep(from, t, direction_ * h, before, trial, M::quintic));
  else if (!closing_in)
    tell();
}

} // namespace insitu::advect

#include "advect/integrate/integration_exits.h"
#include "advect/integrate/integration_faces.h"
