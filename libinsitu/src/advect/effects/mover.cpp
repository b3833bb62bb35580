#include "advect/effects/mover.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "advect/integrate/check.h"
#include "advect/integrate/integrations.h"

namespace insitu::advect {

namespace {

/// A recorder as visitor of integrate().
struct Told {
  Recorder& recorder;

  template <class... Step>
  bool operator()(const State& p, const Step&... path) const {
    recorder(p, path...);
    return !recorder.is_over();
  }
};

} // namespace

EffectSetup::EffectSetup(const Effects& given, const query::Sampler& sampler,
                         const core::Threads& threads)
    : effects(given) {
  if (effects.boundary)
    sides = sides_of(sampler, *effects.boundary, threads);
  if (effects.diffusion)
    largest = largest_coefficients(*effects.diffusion, sampler.mesh(), threads);
}

template <class V>
Mover<V>::Mover(const EffectSetup& setup, V& velocity, const IntegratorSettings& settings,
                double max_length)
    : setup_(&setup), effects_(&setup.effects), settings_(settings), max_length_(max_length),
      velocity_(velocity), space_(effects_->geocentric ? Space::geocentric() : velocity.space()),
      walls_(flow().sampler(), flow().accuracy(), space_, setup.sides, work_),
      boundary_(effects_->boundary.value_or(BoundaryEffect{})), walk_boundary_(boundary_) {
  for (const Drift& drift : effects_->drifts)
    if (drift.field)
      settings_ = settings_for(drift.field->now, settings_);
  if (!effects_->boundary)
    walk_boundary_.response = AtBoundary::reflect;
  puts_back_ = boundary_.response == AtBoundary::put_back;
  if (puts_back_)
    boundary_.response = AtBoundary::leave;
}

template <class V>
insitu_ending Mover<V>::advance(State& p, std::int64_t hint, Carried& carried, double to,
                                Work& work) {
  velocity_.begin(hint);
  spot_cell_ = -1;
  steps_left_ = settings_.max_steps;
  last_bounce_ = -1.0;
  direction_ = to < p.time ? -1.0 : 1.0;
  carried_ = &carried;
  flow_work_ = &work;
  now_.turn.begun = false;
  go_on_from_mark(carried);
  if (!effects_->diffusion)
    return go(p, carried, to, work);

  // The flow and the walk take turns (Lie's splitting).
  const RandomWalk walker(*effects_->diffusion, setup_->largest, flow().sampler(),
                          flow().accuracy());
  if (!now_.turn.begun)
    if (const insitu_ending ending = go(p, carried, goes_on_ ? now_.to : p.time, work);
        ending != INSITU_END_ALIVE)
      return ending; // it was seeded outside, or the mesh has moved away
  KeptMover::Turn& turn = now_.turn;
  while (goes_on_ || p.time < to) {
    if (!goes_on_) {
      const double from = p.time;
      const double dt = walker.step(walls_.edges(cell(), flow().geometry_alpha(from)));
      turn = {true, from, dt < to - from ? from + dt : to};
      if (turn.until == from)
        return INSITU_END_STEP_LIMIT; // a step that the time cannot tell
    }
    if (!goes_on_at(Stage::walk))
      if (const insitu_ending ending = go(p, carried, turn.until, work); ending != INSITU_END_ALIVE)
        return ending;
    take_up();
    if (moves_on(Stage::walk, cell()))
      return INSITU_END_COUNT;
    if (const insitu_ending ending = walk(p, carried, turn.until - turn.from);
        ending != INSITU_END_ALIVE)
      return ending;
    if (--steps_left_ <= 0 && p.time < to)
      return INSITU_END_STEP_LIMIT;
  }
  return INSITU_END_ALIVE;
}

template <class V>
void Mover<V>::mark(KeptMover& to) const {
  to = now_;
  to.spot_cell = spot_cell_;
  to.steps_left = steps_left_;
  to.steps = flow_work_->steps - steps_before_;
  to.last_bounce = last_bounce_;
  to.direction = direction_;
  to.carried = *carried_;
  to.effects = work_;
}

/// A particle that comes from a mark: the mover is as it was there, but for what goes on in
/// integrate(), and the velocity is when take_up() is called.
template <class V>
void Mover<V>::go_on_from_mark(Carried& carried) {
  goes_on_ = false;
  if constexpr (TravellingField<V>) {
    Journey* const journey = velocity_.journey();
    if (!journey)
      return;
    journey->set_mover(this);
    const KeptMover* const from = journey->mover_to_go_on();
    if (!from)
      return;
    goes_on_ = true;
    now_ = *from;
    spot_cell_ = from->spot_cell;
    steps_left_ = from->steps_left;
    last_bounce_ = from->last_bounce;
    direction_ = from->direction;
    carried = from->carried;
  }
}

template <class V>
void Mover<V>::take_up() {
  if constexpr (TravellingField<V>)
    if (goes_on_)
      velocity_.journey()->go_on(velocity_);
  goes_on_ = false;
}

/// The start by the cell's name and, if it exists here, the cell.
template <class V>
void Mover<V>::name_start(KeptMover::Undo& undo) const {
  if constexpr (TravellingField<V>)
    if (const Journey* const journey = velocity_.journey(); journey && undo.inside) {
      if (goes_on_)
        undo.start.cell = journey->homes().find(undo.cell);
      else
        undo.cell = journey->homes().name(undo.start.cell);
    }
}

/// A particle that is put back to where another process has the cell goes there.
template <class V>
bool Mover<V>::moves_back(const KeptMover::Undo& undo) {
  if constexpr (TravellingField<V>)
    if (Journey* const journey = velocity_.journey();
        journey && !(undo.start.cell >= 0 && journey->homes().is_own(undo.start.cell))) {
      now_.stage = Stage::put_back;
      journey->goes_to(velocity_, undo.cell);
      return true;
    }
  return false;
}

/// Between two moves: whether the particle, in this cell, goes on in another process.
template <class V>
bool Mover<V>::moves_on(Stage stage, std::int64_t cell) {
  if constexpr (TravellingField<V>)
    if (Journey* const journey = velocity_.journey()) {
      now_.stage = stage;
      return journey->moves_on(velocity_, cell);
    }
  return false;
}

template <class V>
insitu_ending Mover<V>::walk(State& p, Carried& carried, double dt) {
  Spot at;
  if (!find(p, at))
    return INSITU_END_ALIVE;
  const RandomWalk walker(*effects_->diffusion, setup_->largest, flow().sampler(),
                          flow().accuracy());
  Moved moved;
  if (!walker.walk(at, dt, carried.id, carried.walk_steps, walk_boundary_, flow().alpha(p.time),
                   flow().geometry_alpha(p.time), walls_, moved))
    return INSITU_END_NOT_FINITE;
  ++carried.walk_steps;
  ++work_.walk_steps;
  placed(p, at);
  if (recorder_)
    recorder_->displaced(p);
  return ending_of(moved);
}

/// Where a point is, if it is inside.
template <class V>
bool Mover<V>::find(const Vec3d& point, double time, Spot& at) {
  const query::Location here =
      flow().sampler().locate(point, cell(), {flow().accuracy(), flow().geometry_alpha(time)});
  at = {point, here.cell};
  return bool(here);
}

template <class V>
bool Mover<V>::find(const State& p, Spot& at) {
  Vec3d point;
  if (!velocity_.point(p.x, point))
    return false;
  if (find(point, p.time, at))
    return true;
  if (!flow().blends_geometry() || cell() < 0)
    return false;
  // On a wall that moves: its place at that time is known to rounding of the time, too.
  const Vec3d in = walls_.middle(cell(), flow().geometry_alpha(p.time)) - point;
  return find(point + 1e-9 * in, p.time, at) || find(point + 1e-7 * in, p.time, at);
}

template <class V>
void Mover<V>::placed(State& p, Spot at) {
  if constexpr (requires { velocity_.comes_back(at.x, at.cell, 1.0); }) {
    // Beside a wall a change of charts may round it out: into the cell a little, at its level.
    const double alpha = flow().geometry_alpha(p.time);
    for (double part = 1e-12; part < 1e-2 && !velocity_.comes_back(at.x, at.cell, alpha);
         part *= 16.0) {
      const Vec3d in = walls_.middle(at.cell, alpha) - at.x;
      at.x += Vec3d{part * in.x, part * in.y, 0.0};
    }
  }
  p.x = velocity_.place(at.x);
  spot_cell_ = at.cell;
  velocity_.begin(at.cell);
}

/// By the velocity alone, or that of the particle itself, with the response of the boundary.
template <class V>
insitu_ending Mover<V>::go(State& p, Carried& carried, double to, Work& work) {
  const auto move = [&] {
    return effects_->inertia ? fly(p, carried, to, work) : flow_to(p, to, work);
  };
  now_.to = to;
  if (!puts_back_)
    return move();
  KeptMover::Undo undo = now_.undo;
  if (!goes_on_) {
    undo.before = p;
    undo.inside = find(p, undo.start);
  }
  name_start(undo);
  now_.undo = undo;
  insitu_ending ending = goes_on_at(Stage::put_back) ? INSITU_END_LEFT : move();
  if (ending == INSITU_END_LEFT && undo.inside) {
    if (!goes_on_ && moves_back(undo))
      return INSITU_END_COUNT;
    take_up();
    ending = put_back(p, undo.before, undo.start, to);
    carried.velocity = {};
  }
  return ending;
}

/// A particle that has left is where it was, with the material of a mesh that moves, until `to`.
template <class V>
insitu_ending Mover<V>::put_back(State& p, const State& before, const Spot& start, double to) {
  const Vec3d x =
      walls_.carry(start, flow().geometry_alpha(before.time), flow().geometry_alpha(to));
  p = before;
  p.time = to;
  p.fresh = false;
  Spot at;
  spot_cell_ = start.cell;
  if (!find(x, to, at))
    return INSITU_END_LEFT;
  ++work_.contacts;
  placed(p, at);
  if (recorder_) {
    recorder_->back_to(before, start.x);
    recorder_->straight(p);
  }
  return INSITU_END_ALIVE;
}

template <class V>
insitu_ending Mover<V>::flow_to(State& p, double to, Work& work) {
  for (;;) {
    if (!goes_on_at(Stage::touch)) {
      IntegratorSettings settings = settings_;
      settings.max_steps = std::max<std::int64_t>(steps_left_, 1);
      steps_before_ = work.steps - (goes_on_ ? now_.steps : 0);
      goes_on_ = false; // integrate() takes the particle up
      now_.stage = Stage::flow;
      insitu_ending ending;
      if (recorder_) {
        ending = integrate(velocity_, settings, to, max_length_, p, work, Told{*recorder_});
        if (is_over())
          return INSITU_END_REMOVED;
        if (ending == INSITU_END_COUNT)
          return ending;
        recorder_->straight(p);
      } else {
        ending = integrate(velocity_, settings, to, max_length_, p, work, Visitor());
        if (ending == INSITU_END_COUNT)
          return ending;
      }
      // Steps that close in on a wall count as one.
      steps_left_ -= ending == INSITU_END_LEFT ? 1 : work.steps - steps_before_;
      if (velocity_.cell() >= 0)
        spot_cell_ = -1;
      if (ending != INSITU_END_LEFT || !effects_->boundary)
        return ending;
    }
    if (const insitu_ending after = touch(p, to, work); after != INSITU_END_ALIVE)
      return after;
    if (steps_left_ <= 0)
      return INSITU_END_STEP_LIMIT;
  }
}

INSITU_MOVERS()

} // namespace insitu::advect
