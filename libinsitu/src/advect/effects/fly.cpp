// Particles with inertia: Mover's way of moving them.
#include <algorithm>
#include <cmath>
#include <limits>

#include "advect/effects/mover.h"
#include "cells/kernels/kernels.h"

namespace insitu::advect {

namespace {

constexpr double first_cells = 0.1, largest_cells = 1.0, fixed_cells = 0.25;
constexpr double safety = 0.9, largest_growth = 5.0, smallest_factor = 0.2;
constexpr double largest_relative_error = 0.01;
constexpr int most_trials = 2200; // halving 1e308 to 1e-308 takes 2047

/// The velocity of the mesh at a place, if it moves.
Vec3d mesh_velocity(const MeshVelocity& flow, const query::Location& at) {
  const mesh::MeshView& mesh = flow.sampler().mesh();
  if (!flow.blends_geometry())
    return {};
  mesh::CellVertices then, now;
  mesh::gather(mesh, at.cell, then, 0.0);
  mesh::gather(mesh, at.cell, now, 1.0);
  double weight[8];
  cells::shape_functions(now.shape, at.parametric, weight);
  Vec3d moved;
  for (int v = 0; v < now.count; ++v)
    moved += weight[v] * (now.x[v] - then.x[v]);
  return moved / flow.interval();
}

} // namespace

/// b of inertial_step(): what moves the particle besides what is linear in its own velocity.
template <class V>
Sampled Mover<V>::force(const Vec3d& x, double t, Vec3d& b) {
  const Inertia& inertia = *effects_->inertia;
  query::Location at;
  Vec3d u;
  if (const Sampled s = velocity_.sample(x, t, u, at); s != Sampled::inside)
    return s;
  b = space_.from_scene(x, inertia.acceleration);
  if (std::isfinite(inertia.response_time))
    b += u / inertia.response_time;
  if (inertia.fluid_share != 0.0) {
    // Du/Dt = du/dt at a place that goes with the mesh + (u - the mesh's velocity) grad u, and the
    // axes turn where the fluid goes.
    const Vec3d relative = walls_.scale(x).coordinates(u) - mesh_velocity(flow(), at);
    Vec3d acceleration = velocity_.rate_of_change(at, t);
    for (int c = 0; c < 3; ++c)
      acceleration[c] += math::dot(velocity_.gradient(at, c, t), relative);
    const double spin = space_.spin(x, u);
    acceleration += Vec3d{-spin * u.y, spin * u.x, 0.0};
    b += inertia.fluid_share * acceleration;
  }
  return std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.z) ? Sampled::inside
                                                                        : Sampled::not_finite;
}

/// The law with the rotation along the axes at x.
template <class V>
Inertia Mover<V>::law_at(const Vec3d& x) const {
  Inertia law = *effects_->inertia;
  law.rotation = space_.from_earth(x, law.rotation);
  return law;
}

template <class V>
insitu_ending Mover<V>::fly(State& p, Carried& carried, double to, Work& work) {
  Vec3d x = now_.flier.x;
  if (!goes_on_) { // else it is in flight, and its velocity along the axes there
    if (!velocity_.point(p.x, x))
      return p.fresh ? INSITU_END_SEED_OUTSIDE : INSITU_END_LEFT;
    carried.velocity = space_.from_east_north(x, carried.velocity);
  }
  const insitu_ending ending = fly_from(x, p, carried, to, work);
  carried.velocity = space_.to_east_north(x, carried.velocity);
  if (Spot at; ending == INSITU_END_ALIVE && space_.is_curved() && find(x, p.time, at))
    placed(p, at);
  else
    p.x = velocity_.place(x);
  return ending;
}

namespace {

/// Whether a way from x goes through the wall from which `back` brings a point back, by more than
/// rounding makes of x.
bool presses(const Vec3d& way, const Vec3d& back, const Vec3d& x) {
  const double rounding = 64.0 * std::numeric_limits<double>::epsilon() *
                          std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)});
  return -math::dot(way, back) > rounding * length_of(back);
}

} // namespace

/// A particle on its way, and what its next step begins with.
template <class V>
struct Mover<V>::Flier {
  Vec3d& x; ///< its point among the cells
  State& p;
  Carried& carried;
  const double to;
  Work& work;
  Vec3d force = {}; ///< b of inertial_step(), at x
  bool knows_force = false;
  bool begun = false;    ///< its first place was recorded
  bool closing = false;  ///< in on an obstacle: a step has left the mesh
  double too_long = 0.0; ///< the longest step that left the mesh, while closing
};

/// One step of it, of which the length is tried until it will do.
template <class V>
struct Mover<V>::FlightStep {
  Vec3d v;      ///< velocity at the beginning
  Vec3d extent; ///< of the cell there
  Scale per_metre;
  Inertia law;
  double cell_time = 0.0; ///< to cross a cell
  double remaining = 0.0, length_left = 0.0;
  double wanted = 0.0, h = 0.0; ///< length in time, before and after the limits

  InertialTrial trial; ///< the last one
  double cells = 0.0;  ///< that it crosses
  double chord = 0.0;  ///< its length
  double relative_error = 1e-4;
  bool cut = false;     ///< by the limits
  bool retried = false; ///< after a longer trial
  bool forced = false;  ///< taken as the smallest step, with an error over the tolerance

  bool is_close(double tolerance) const { return cells <= tolerance && h <= tolerance * cell_time; }
};

template <class V>
insitu_ending Mover<V>::fly_from(Vec3d& x, State& p, Carried& carried, double to, Work& work) {
  Flier f{x, p, carried, to, work};
  if (goes_on_) {
    const KeptMover::Flier& from = now_.flier;
    x = from.x;
    f.force = from.force;
    f.knows_force = from.knows_force;
    f.begun = from.begun;
    f.closing = from.closing;
    f.too_long = from.too_long;
    if (now_.stage == Stage::touch_flying)
      if (const insitu_ending ending = touch_flying(x, p, carried, to, work);
          ending != INSITU_END_ALIVE)
        return ending;
    take_up();
  }
  for (;;) {
    if (travels() && cell() >= 0) {
      p.x = velocity_.place(x);
      now_.flier = {x, f.force, f.knows_force, f.begun, f.closing, f.too_long};
      if (moves_on(Stage::fly, cell()))
        return INSITU_END_COUNT;
    }
    insitu_ending ending = f.knows_force ? INSITU_END_ALIVE : feel(f);
    if (ending != INSITU_END_ALIVE || !(p.time < to))
      return ending;
    FlightStep step;
    if (ending = plan(f, step); ending != INSITU_END_ALIVE)
      return ending;
    ending = try_lengths(f, step);
    if (ending == INSITU_END_ALIVE) {
      ending = accept(f, step);
    } else if (ending == INSITU_END_LEFT) {
      f.closing = f.knows_force = false;
      p.step = 0.0;
      if (effects_->boundary)
        ending = touch_flying(x, p, carried, to, work);
    }
    if (ending != INSITU_END_ALIVE)
      return ending;
  }
}

/// Asks for the force where the particle is, and for the velocity of one that is new.
template <class V>
insitu_ending Mover<V>::feel(Flier& f) {
  Vec3d u;
  query::Location at;
  f.work.evaluations += 2;
  Sampled s = velocity_.sample(f.x, f.p.time, u, at);
  if (s == Sampled::inside)
    s = force(f.x, f.p.time, f.force);
  if (s != Sampled::inside)
    return s == Sampled::not_finite ? INSITU_END_NOT_FINITE
           : f.p.fresh              ? INSITU_END_SEED_OUTSIDE
                                    : INSITU_END_LEFT;
  velocity_.accepted();
  f.x = kept_inside(f.x);
  spot_cell_ = -1;
  f.p.fresh = false;
  if (std::isnan(f.carried.velocity.x))
    f.carried.velocity =
        effects_->inertia->begins ? space_.from_scene(f.x, *effects_->inertia->begins) : u;
  f.knows_force = true;
  if (recorder_) {
    f.p.x = velocity_.place(f.x);
    f.begun ? recorder_->straight(f.p) : (*recorder_)(f.p);
    if (is_over())
      return INSITU_END_REMOVED;
  }
  f.begun = true;
  return INSITU_END_ALIVE;
}

/// Finds the length with which the next step is tried first; or why there is none.
template <class V>
insitu_ending Mover<V>::plan(const Flier& f, FlightStep& step) const {
  const bool adaptive = is_adaptive(settings_.method);
  step.remaining = f.to - f.p.time;
  step.length_left = max_length_ - f.p.length;
  step.extent = walls_.extent(cell(), flow().geometry_alpha(f.p.time));
  step.per_metre = walls_.scale(f.x);
  step.law = law_at(f.x);
  step.v = f.carried.velocity;
  const double cells = cells_crossed(step.per_metre.coordinates(step.v), step.extent);
  if (!std::isfinite(cells))
    return INSITU_END_NOT_FINITE;
  if (std::isfinite(max_length_) && step.length_left <= 1e-12 * max_length_)
    return INSITU_END_EXPIRED;
  if (steps_left_ <= 0)
    return INSITU_END_STEP_LIMIT;

  step.cell_time = cells > 0.0 ? 1.0 / cells : step.remaining;
  double limit = (adaptive ? largest_cells : fixed_cells) * step.cell_time;
  if (settings_.max_step > 0.0)
    limit = settings_.max_step;
  double wanted = f.p.step;
  if (!f.closing && !adaptive)
    wanted = settings_.step > 0.0 ? settings_.step : limit;
  else if (wanted == 0.0)
    wanted = settings_.step > 0.0 ? settings_.step : first_cells * step.cell_time;
  step.h = std::min({wanted, adaptive || settings_.step == 0.0 ? limit : wanted, step.remaining});
  if (const double speed = length_of(step.v); speed > 0.0)
    step.h = std::min(step.h, step.length_left / speed);
  step.wanted = wanted;
  step.cut = step.h < wanted;
  return INSITU_END_ALIVE;
}

/// Tries the step, shorter and shorter, until it will do. INSITU_END_LEFT: it leaves the mesh,
/// however short it is.
template <class V>
insitu_ending Mover<V>::try_lengths(Flier& f, FlightStep& step) {
  for (int trials = 0;; ++trials) {
    const bool is_last = trials == most_trials;
    try_once(f, step);
    if (step.trial.sampled == Sampled::not_finite && step.cells <= settings_.exit_tolerance)
      return INSITU_END_NOT_FINITE;
    double factor = 0.5;
    if (step.trial.sampled == Sampled::inside) {
      factor = factor_after(step, is_last);
    } else {
      if (is_last || step.is_close(settings_.exit_tolerance) || f.p.time + 0.5 * step.h == f.p.time)
        return INSITU_END_LEFT;
      f.too_long = f.closing ? std::max(f.too_long, step.h) : step.h;
      f.closing = true;
    }
    if (step.forced && settings_.min_step > 0.0 && settings_.at_min_step == AtMinStep::end) {
      ++f.work.rejected;
      return INSITU_END_STEP_TOO_SMALL;
    }
    if (factor == 1.0)
      return INSITU_END_ALIVE;
    ++f.work.rejected;
    step.retried = true;
    step.h *= factor;
  }
}

template <class V>
void Mover<V>::try_once(const Flier& f, FlightStep& step) {
  const Vec3d& x = f.x;
  const auto stage = [&](const Vec3d& y, double t, Vec3d& at_y) { return force(y, t, at_y); };
  const auto go = [&](const Vec3d& d) {
    return space_.image(x + space_.displacement(x, d), space_.pole_of(x));
  };
  const auto back = [&](const Vec3d& y, const Vec3d& at_y) {
    if (!space_.is_curved())
      return at_y;
    // The rotation is another there: what that changes, by the velocity at the start.
    const Vec3d other = space_.transport(y, x, law_at(y).rotation) - step.law.rotation;
    return space_.transport(y, x, at_y) - 2.0 * math::cross(other, step.v);
  };
  step.trial = inertial_step(stage, go, back, step.law, step.v, f.p.time, step.h, f.force);
  f.work.evaluations += 3;
  step.cells = cells_crossed(step.per_metre.coordinates(step.trial.moved), step.extent);
  step.chord = length_of(step.trial.moved);
  if (step.trial.sampled == Sampled::inside && (f.closing || effects_->boundary) &&
      is_kept_back(f, step))
    step.trial.sampled = Sampled::outside;
}

/// Whether the end of a step is only brought back to a wall by rounding: such steps, since they are
/// so short, would go on without end. A wall that responds takes them all; others are left by what
/// goes on through them.
template <class V>
bool Mover<V>::is_kept_back(const Flier& f, const FlightStep& step) {
  const Vec3d to_wall = kept_inside(step.trial.x) - step.trial.x;
  if (to_wall == Vec3d{})
    return false;
  if (effects_->boundary || step.is_close(settings_.exit_tolerance))
    return true;
  const Vec3d on =
      f.too_long * step.v + (0.5 * f.too_long * f.too_long / step.h) * (step.trial.v - step.v);
  return presses(step.per_metre.coordinates(on), to_wall, f.x);
}

/// The part of its length with which a step that ends inside is tried again; 1: it will do.
template <class V>
double Mover<V>::factor_after(FlightStep& step, bool is_last) const {
  const bool adaptive = is_adaptive(settings_.method);
  if (step.cells > 2.0 * largest_cells && settings_.max_step == 0.0 && adaptive)
    return std::max(largest_cells / step.cells, 1e-3);
  if (step.chord > step.length_left * (1.0 + 1e-12) && !is_last)
    return std::min(step.length_left / step.chord, 1.0 - 1e-12);
  if (!adaptive)
    return 1.0;
  const double fastest = std::max(length_of(step.v), length_of(step.trial.v));
  const double tolerance =
      std::max(std::min(settings_.tolerance, largest_relative_error * fastest), 1e-300);
  step.relative_error = std::max(step.trial.error / tolerance, 1e-4);
  if (!(step.relative_error > 1.0))
    return 1.0;
  step.forced = is_last || (settings_.min_step > 0.0 ? step.h <= settings_.min_step
                                                     : step.cells <= settings_.min_cells);
  return step.forced ? 1.0
                     : std::max({smallest_factor, safety / std::sqrt(step.relative_error),
                                 std::min(settings_.min_step / step.h, 1.0 - 1e-12)});
}

/// Takes the particle to the end of the step, and tells the recorder.
template <class V>
insitu_ending Mover<V>::accept(Flier& f, FlightStep& step) {
  const double until = step.h == step.remaining ? f.to : f.p.time + step.h;
  velocity_.accepted();
  step.trial.x = kept_inside(step.trial.x);
  if (recorder_) {
    State then = f.p;
    then.x = velocity_.place(step.trial.x);
    then.time = until;
    recorder_->flew(then,
                    Flight(space_, step.law, f.x, step.v, f.p.time, step.h, f.force, step.trial));
    if (is_over())
      return INSITU_END_REMOVED;
  }
  ++f.work.steps;
  f.work.forced += step.forced;
  steps_left_ -= !(f.closing && step.retried);
  f.carried.velocity = space_.transport(f.x, step.trial.x, step.trial.v);
  f.x = step.trial.x;
  f.p.time = until;
  f.p.length += step.chord;
  f.force = step.trial.force;
  if (f.closing) {
    f.p.step = step.h;
    f.closing = step.retried; // two steps of one size in a row: past the obstacle
  } else if (is_adaptive(settings_.method)) {
    const double factor = step.forced
                              ? largest_growth
                              : std::clamp(safety / std::sqrt(step.relative_error), smallest_factor,
                                           step.retried ? 1.0 : largest_growth);
    f.p.step = step.cut && !step.retried ? std::max(step.wanted, step.h * factor) : step.h * factor;
  }
  return INSITU_END_ALIVE;
}

INSITU_MOVERS()

} // namespace insitu::advect
