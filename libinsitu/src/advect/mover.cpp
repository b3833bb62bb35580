#include "advect/mover.h"

#include <algorithm>
#include <cmath>

#include "advect/check.h"

namespace insitu::advect {

namespace {

/// The part of a cell that a particle goes on along a wall, or back from it, in one step.
constexpr double contact_cells = 0.1;

} // namespace

EffectSetup::EffectSetup(const Effects& given, const query::Sampler& sampler,
                         const core::Threads& threads)
    : effects(given) {
  if (effects.boundary && effects.boundary->any_periodic())
    box = box_of(sampler.mesh(), threads);
  if (effects.diffusion)
    largest = largest_coefficients(*effects.diffusion, sampler.mesh(), threads);
}

Mover::Mover(const EffectSetup& setup, MeshVelocity& flow, const IntegratorSettings& settings,
             double max_length)
    : setup_(&setup), effects_(&setup.effects), settings_(settings), max_length_(max_length),
      flow_(flow), velocity_(flow_, effects_->drifts),
      walls_(flow_.sampler(), flow_.accuracy(), effects_->metric, setup.box, work_),
      boundary_(effects_->boundary.value_or(BoundaryEffect{})), walk_boundary_(boundary_) {
  for (const Drift& drift : effects_->drifts)
    if (drift.field)
      settings_ = settings_for(drift.field->now, settings_);
  if (!effects_->boundary)
    walk_boundary_.response = AtBoundary::reflect;
}

insitu_ending Mover::advance(State& p, std::int64_t hint, Carried& carried, double to, Work& work) {
  flow_.begin(hint);
  spot_cell_ = -1;
  steps_left_ = settings_.max_steps;
  last_bounce_ = -1.0;
  if (!effects_->diffusion)
    return flow_to(p, carried, to, work);

  // The flow and the walk take turns (Lie's splitting).
  const RandomWalk walker(*effects_->diffusion, setup_->largest, flow_.sampler(), flow_.accuracy());
  if (const insitu_ending ending = flow_to(p, carried, p.time, work); ending != INSITU_END_ALIVE)
    return ending; // it was seeded outside, or the mesh has moved away
  while (p.time < to) {
    const double from = p.time;
    const Vec3d extent = walls_.extent(cell(), flow_.geometry_alpha(from));
    const double dt = walker.step(over_axis(extent, walls_.scale(p.x)));
    const double until = dt < to - from ? from + dt : to;
    if (until == from)
      return INSITU_END_STEP_LIMIT; // a step that the time cannot tell
    if (const insitu_ending ending = flow_to(p, carried, until, work); ending != INSITU_END_ALIVE)
      return ending;
    if (const insitu_ending ending = walk(p, carried, until - from); ending != INSITU_END_ALIVE)
      return ending;
    if (--steps_left_ <= 0 && p.time < to)
      return INSITU_END_STEP_LIMIT;
  }
  return INSITU_END_ALIVE;
}

insitu_ending Mover::walk(State& p, Carried& carried, double dt) {
  Spot at;
  if (!place(p, at))
    return INSITU_END_ALIVE;
  const RandomWalk walker(*effects_->diffusion, setup_->largest, flow_.sampler(), flow_.accuracy());
  Moved moved;
  if (!walker.walk(at, dt, carried.id, carried.walk_steps, walk_boundary_, flow_.alpha(p.time),
                   flow_.geometry_alpha(p.time), walls_, moved))
    return INSITU_END_NOT_FINITE;
  ++carried.walk_steps;
  ++work_.walk_steps;
  placed(p, at);
  if (taker_)
    taker_->displaced(p);
  return ending_of(moved);
}

/// After a step along the wall: straight, through periodic sides if that is the shorter way.
void Mover::take_contact(const State& p) {
  if (!taker_)
    return;
  taker_->along(p, [&](const Vec3d& from, double part) {
    Vec3d x = p.x - from;
    for (int a = 0; a < 3; ++a) {
      const double low = setup_->box.low[a], size = setup_->box.high[a] - low;
      if (boundary_.periodic[a] && size > 0.0) {
        const double to = from[a] + part * (x[a] - size * std::round(x[a] / size));
        x[a] = to < low ? to + size : to > low + size ? to - size : to;
      } else {
        x[a] = from[a] + part * x[a];
      }
    }
    return x;
  });
}

/// Where the particle is, if it is inside.
bool Mover::place(State& p, Spot& at) {
  const std::int64_t hint = cell();
  const query::Location here =
      flow_.sampler().locate(p.x, hint, {flow_.accuracy(), flow_.geometry_alpha(p.time)});
  at = {p.x, here.cell};
  return bool(here);
}

void Mover::placed(State& p, const Spot& at) {
  p.x = at.x;
  spot_cell_ = at.cell;
  flow_.begin(at.cell);
}

/// By the velocity alone, with the response of the boundary.
insitu_ending Mover::flow_to(State& p, Carried& carried, double to, Work& work) {
  if (effects_->inertia)
    return fly(p, carried, to, work);
  for (;;) {
    IntegratorSettings settings = settings_;
    settings.max_steps = std::max<std::int64_t>(steps_left_, 1);
    const std::int64_t steps = work.steps;
    insitu_ending ending;
    if (taker_) {
      ending = integrate(velocity_, settings, to, max_length_, p, work, *taker_);
      taker_->straight(p);
    } else {
      ending = integrate(velocity_, settings, to, max_length_, p, work, [](const State&) {});
    }
    // Steps that close in on a wall count as one.
    steps_left_ -= ending == INSITU_END_LEFT ? 1 : work.steps - steps;
    if (flow_.cell() >= 0)
      spot_cell_ = -1;
    if (ending != INSITU_END_LEFT || !effects_->boundary)
      return ending;
    if (const insitu_ending after = touch(p, to, work); after != INSITU_END_ALIVE)
      return after;
    if (steps_left_ <= 0)
      return INSITU_END_STEP_LIMIT;
  }
}

/// A particle that leaves or stops where it is, or else comes in again at a periodic side.
insitu_ending Mover::pass(State& p, Spot at) {
  Vec3d v;
  flow_.begin(at.cell);
  if (const Sampled s = velocity_(at.x, p.time, v); s != Sampled::inside)
    return s == Sampled::outside ? INSITU_END_LEFT : INSITU_END_NOT_FINITE;
  --steps_left_;
  const double alpha = flow_.geometry_alpha(p.time);
  const double skins = cells_crossed(v, walls_.skin(at, alpha));
  const std::int64_t contacts = work_.contacts;
  const Moved moved =
      skins > 0.0 ? walls_.move(at, (8.0 / skins) * v, boundary_, alpha, p.length) : Moved::left;
  if (moved == Moved::inside && work_.contacts == contacts)
    return ending_of(boundary_.response == AtBoundary::stop ? Moved::stopped : Moved::left);
  placed(p, at);
  if (taker_)
    taker_->set(p);
  return ending_of(moved);
}

/// A particle that the velocity takes out of the mesh: goes on along the wall, or back from it, for
/// as long as the velocity presses it to the wall.
insitu_ending Mover::touch(State& p, double to, Work& work) {
  Spot at;
  if (!place(p, at))
    return INSITU_END_LEFT; // the mesh has moved away from it
  if (boundary_.response == AtBoundary::leave || boundary_.response == AtBoundary::stop)
    return pass(p, at);
  do {
    Vec3d v;
    ++work.evaluations;
    flow_.begin(at.cell);
    if (const Sampled s = velocity_(at.x, p.time, v); s != Sampled::inside)
      return s == Sampled::outside ? INSITU_END_LEFT : INSITU_END_NOT_FINITE;
    velocity_.accepted();
    const double cells = cells_crossed(v, flow_.extent());
    double h = std::min(cells > 0.0 ? contact_cells / cells : to - p.time, to - p.time);
    if (settings_.max_step > 0.0)
      h = std::min(h, settings_.max_step);
    if (max_length_ - p.length < length_of(v) * h)
      h = (max_length_ - p.length) / length_of(v);
    const double now = flow_.geometry_alpha(p.time);
    const double then = flow_.geometry_alpha(p.time + h);
    // Heun's method along the wall. What the wall itself moves is not resisted.
    Vec3d mean = v;
    Spot end = at;
    end.x = walls_.carry(at, now, then);
    const Vec3d shift = end.x - at.x;
    if (boundary_.response == AtBoundary::slide) {
      Spot ahead = end;
      double length = 0.0;
      BoundaryEffect quiet = boundary_;
      Vec3d v1;
      if (walls_.move(ahead, h * v - shift, quiet, then, length) == Moved::inside) {
        flow_.begin(ahead.cell);
        ++work.evaluations;
        if (velocity_(ahead.x, p.time + h, v1) == Sampled::inside)
          mean = 0.5 * (v + v1);
      }
    }
    const Vec3d d = h * mean - shift;
    const Moved moved = walls_.move(end, d, boundary_, then, p.length);
    const Vec3d n = walls_.wall();
    at = end;
    p.time = h < to - p.time ? p.time + h : to;
    placed(p, at);
    take_contact(p);
    ++work.steps;
    --steps_left_;
    if (moved != Moved::inside)
      return ending_of(moved);
    // On a flat wall it saves a step to find the wall again, to ask what is behind it.
    const Vec3d behind = by_axis(n, walls_.skin(at, then));
    if (boundary_.response != AtBoundary::slide || n == Vec3d{} ||
        walls_.is_inside(at.x + 8.0 * behind, at.cell, then) ||
        !(math::dot(over_axis(v, walls_.scale(at.x)), n) > 0.0))
      break;
  } while (p.time < to && steps_left_ > 0 && p.length < max_length_);
  return INSITU_END_ALIVE;
}

} // namespace insitu::advect
