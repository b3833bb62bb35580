#pragma once

#include <concepts>

#include "advect/integrate/integrations.h"
#include "advect/lines/interval.h"
#include "query/walk/beside_mesh.h"

/// Particles moved one by one in one interval: see Interval.
namespace insitu::advect {

/// The velocity between two steps on different cells.
template <class V>
inline constexpr bool is_crossing = false;
template <class V>
inline constexpr bool is_crossing<CrossingVelocity<V>> = true;

/// make() gives each thread its velocity; effects, if there are any, move particles in it.
template <class Make>
void Interval::carry(Make&& make) {
  using V = decltype(make());
  note(make());
  asked_.threads.parallel_for(count(), grain_, [&](std::int64_t begin, std::int64_t end) {
    V velocity = make();
    velocity.walk_by(beyond_.get());
    if (!setup_)
      return flow(velocity, begin, end);
    Mover<V> mover(*setup_, velocity, integrator_, settings_.length);
    move(velocity, mover, begin, end);
    effect_work_[std::size_t(begin / grain_)] = mover.effect_work();
  });
}

/// A position in the mesh's frame: where rounding on the way from a chart has it beyond a wall, in
/// the mesh.
template <class V>
math::Vec3d Interval::in_frame(const V& velocity, const State& p, std::int64_t cell) const {
  math::Vec3d x = velocity.position(p.x);
  const query::LocateOptions options{settings_.accuracy, velocity.geometry_alpha(p.time)};
  if (cell >= 0 && !(x == p.x) && !here_.locate(x, cell, options))
    (void)query::bring_inside(here_, x, query::rounding_in(here_.mesh(), cell, options.alpha),
                              options);
  return x;
}

/// Particles [begin, end) by integrate() alone.
template <class V>
void Interval::flow(V& velocity, std::int64_t begin, std::int64_t end) {
  Work& work = work_of(begin);
  for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i) {
    State p;
    double to = 0.0;
    if (!prepare(i, p, to))
      continue;
    velocity.begin(hint(i));
    p.x = velocity.enter(p.x);
    std::optional<SnapshotTaker<V>> taker;
    insitu_ending ending;
    if (asked_.snapshots) {
      taker.emplace(*asked_.snapshots, i, p, velocity, asked_.sampler, settings_.accuracy,
                    no_sides_);
      ending = integrate(velocity, integrator_, to, settings_.length, p, work, *taker);
      taker->straight(p);
    } else {
      ending = integrate(velocity, integrator_, to, settings_.length, p, work, Visitor());
    }
    const std::int64_t cell = velocity.cell();
    p.x = in_frame(velocity, p, cell);
    ending = store(i, p, cell, ending, velocity.geometry_alpha(p.time));
    if (taker && ending != INSITU_END_ALIVE)
      taker->ended(p);
  }
}

/// Where only the step before has cells yet, and so there are no walls, a particle goes with the
/// flow until the current ones, whose velocity is `current`, hold it. either: the velocity of both
/// steps. Returns how the particle ends before, if it does. On several processes the cell that
/// holds it may be another one's (Journey::far_cell).
template <class V>
std::optional<insitu_ending> come_in(CrossingVelocity<V>& current, CrossingVelocity<V>& either,
                                     std::int64_t hint, const IntegratorSettings& integrator,
                                     double to, double length, State& p, Work& work,
                                     Recorder* taker) {
  struct UntilIn {
    CrossingVelocity<V>&either, &current;
    Recorder* taker;
    bool operator()(const State& s) const {
      current.go_by(either);
      if (taker)
        (*taker)(s);
      return either.cell() == -1;
    }
    bool operator()(const State& s, const DenseStep& path) const {
      current.go_by(either);
      if (taker)
        (*taker)(s, path);
      return either.cell() == -1;
    }
  };
  either.begin(hint);
  either.go_by(current);
  const UntilIn until{either, current, taker};
  const insitu_ending ending = integrate(either, integrator, to, length, p, work, until);
  current.go_by(either);
  if (either.cell() == -1 || (ending != INSITU_END_REMOVED && ending != INSITU_END_ALIVE))
    return ending;
  return std::nullopt;
}

/// Particles [begin, end) under effects.
template <class V>
void Interval::move(V& velocity, Mover<V>& mover, std::int64_t begin, std::int64_t end) {
  Work& work = work_of(begin);
  for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i) {
    State p;
    double to = 0.0;
    if (!prepare(i, p, to))
      continue;
    p.x = velocity.enter(p.x);
    std::optional<SnapshotTaker<V>> taker;
    if (asked_.snapshots)
      taker.emplace(*asked_.snapshots, i, p, velocity, asked_.sampler, settings_.accuracy,
                    setup_->sides);
    mover.take(taker ? &*taker : nullptr);
    std::optional<insitu_ending> ends;
    if constexpr (is_crossing<V>)
      if (!effects_.inertia &&
          !asked_.sampler.locate(velocity.position(p.x), -1, {settings_.accuracy})) {
        V either = crossing<V>(Between::either);
        ends = come_in(velocity, either, hint(i), integrator_, to, settings_.length, p, work,
                       taker ? &*taker : nullptr);
      }
    std::int64_t cell = -1;
    insitu_ending ending;
    if (ends) {
      ending = *ends;
    } else {
      Carried carried = particles_.carried(i);
      ending = mover.advance(p, hint(i), carried, to, work);
      particles_.set_carried(i, carried);
      cell = mover.cell();
    }
    p.x = in_frame(velocity, p, cell);
    ending = store(i, p, cell, ending, velocity.geometry_alpha(p.time));
    if (taker && ending != INSITU_END_ALIVE)
      taker->ended(p);
  }
}

} // namespace insitu::advect
