// Particles on several processes: see Interval.
#include <algorithm>
#include <type_traits>
#include <utility>

#include "advect/across/effects_across.h"
#include "advect/across/exits_across.h"
#include "advect/integrate/integrations.h"
#include "advect/lanes/lanes.h"
#include "advect/lines/interval_one_by_one.h"

namespace insitu::advect {

/// One particle's way here, until its end or until another process goes on with it.
template <class V>
struct Interval::Leg {
  State p;
  Work work;
  OnTheWay way; ///< as it began here
  double to = 0.0;
  bool moves = false;
  std::optional<SnapshotTaker<V>> taker;
  std::optional<Journey> journey;
};

template <class V>
void Interval::begin_leg(Leg<V>& leg, std::size_t i, V& velocity, const Rounds& rounds,
                         const EffectWork& effects) {
  leg.way = rounds.way_of(i);
  leg.work = {};
  leg.moves = prepare(i, leg.p, leg.to);
  if (!leg.moves)
    return;
  const WayMark& mark = leg.way.mark;
  velocity.begin(hint(i));
  if (leg.way.is_marked) {
    leg.p = mark.p;
    velocity.enter_as(mark.field);
  } else {
    leg.p.x = velocity.enter(leg.p.x);
  }
  if (asked_.snapshots) {
    leg.taker.emplace(*asked_.snapshots, i, leg.p, velocity, here_, settings_.accuracy,
                      setup_ ? setup_->sides : no_sides_);
    if (leg.way.is_marked)
      leg.taker->go_on_from(mark.recorder);
  }
  leg.journey.emplace(rounds.homes());
  const Marked* const recorder = leg.taker ? &*leg.taker : nullptr;
  if (leg.way.is_marked)
    leg.journey->begin(mark, leg.way.stays, leg.p, leg.work, recorder, effects);
  else
    leg.journey->begin(leg.p, leg.work, recorder);
  velocity.travel_by(&*leg.journey);
}

/// The particle is at its end, or has been taken as far as it can go here. Returns whether it is at
/// its end.
template <class V>
bool Interval::end_leg(Leg<V>& leg, std::size_t i, V& velocity, Rounds& rounds, Work& done,
                       core::FunctionRef<insitu_ending(std::int64_t& cell)> end) {
  const Journey& journey = *leg.journey;
  const auto goes_on = [&] {
    const OnTheWay way = leg.way.after(journey);
    if (leg.taker)
      leg.taker->go_on_from(journey.mark().recorder);
    if (!way.is_marked)
      return way;
    done += way.mark.work;
    State at = way.mark.p;
    at.x = velocity.position_as(way.mark.field, at.x);
    particles_.set_state(i, at, way.mark.cell);
    return way;
  };
  try {
    std::int64_t cell = -1;
    insitu_ending ending = end(cell);
    if (ending == INSITU_END_COUNT) {
      rounds.moves(i, goes_on());
      return false;
    }
    ending = store(i, leg.p, cell, ending, velocity.geometry_alpha(leg.p.time));
    if (leg.taker && ending != INSITU_END_ALIVE)
      leg.taker->ended(leg.p);
    done += leg.work;
    return true;
  } catch (const query::Elsewhere& at) {
    rounds.waits(i, goes_on(), at);
    return false;
  }
}

/// Many particles at a time, by the flow alone.
void Interval::lanes_across(Rounds& rounds, std::span<const std::size_t> particles) {
  const auto count = std::int64_t(particles.size());
  asked_.threads.parallel_for(count, grain_, [&](std::int64_t begin, std::int64_t end) {
    Work done;
    std::vector<Leg<LaneVelocity>> legs(
        std::size_t(std::min<std::int64_t>(LaneBatch::lane_count, end - begin)));
    run_lanes(
        here_, begin, end,
        [&](std::deque<LaneVelocity>& to) {
          LaneVelocity& v = to.emplace_back(here_, velocity_, earlier(), asked_.t0, asked_.t1,
                                            settings_.accuracy);
          v.walk_by(beyond_.get());
          v.take_boundaries();
        },
        [&](std::int64_t item, std::size_t slot, LaneVelocity& v) -> Stepping {
          Leg<LaneVelocity>& leg = legs[slot];
          begin_leg(leg, particles[std::size_t(item)], v, rounds, {});
          if (!leg.moves)
            return {};
          const Visitor visitor = leg.taker ? Visitor(*leg.taker) : Visitor();
          return integration(v, integrator_, leg.to, settings_.length, leg.p, leg.work, visitor);
        },
        [&](std::int64_t item, std::size_t slot, LaneVelocity& v, const Stepping& stepping) {
          Leg<LaneVelocity>& leg = legs[slot];
          const auto way_ends = [&](std::int64_t& cell) {
            const insitu_ending ending = stepping.ending();
            cell = v.cell();
            if (leg.taker && ending != INSITU_END_COUNT)
              leg.taker->straight(leg.p);
            return ending;
          };
          end_leg(leg, particles[std::size_t(item)], v, rounds, done, way_ends);
        });
    const std::lock_guard lock(left_mutex_);
    result_.work += done;
  });
}

namespace {

/// Marks a particle that the mover does not have yet.
struct Beginning final : MarkedMover {
  KeptMover kept;
  void mark(KeptMover& to) const override { to = kept; }
};

} // namespace

/// See come_in(). Returns how the leg ends before the mover has the particle, if it does.
template <class V>
std::optional<insitu_ending> Interval::come_in_across(Leg<V>& leg, V& velocity, std::int64_t hint,
                                                      const KeptMover& beginning) {
  using Stage = KeptMover::Stage;
  Journey& journey = *leg.journey;
  const KeptMover* const from = journey.mover_to_go_on();
  if (from && from->stage == Stage::begin)
    journey.begin_at_mark();
  if (from ? from->stage != Stage::come_in
           : effects_.inertia || here_.locate(velocity.position(leg.p.x), -1, {settings_.accuracy}))
    return std::nullopt;
  Beginning marks;
  marks.kept = beginning;
  marks.kept.stage = Stage::come_in;
  journey.set_mover(&marks);
  V either = crossing<V>(Between::either);
  either.travel_by(&journey);
  if (const auto ending = come_in(velocity, either, hint, integrator_, leg.to, settings_.length,
                                  leg.p, leg.work, leg.taker ? &*leg.taker : nullptr))
    return ending;
  marks.kept.stage = Stage::begin;
  if (journey.moves_on(either, either.cell()))
    return INSITU_END_COUNT;
  return std::nullopt;
}

/// One by one, under effects or on a chart; make() gives a velocity.
template <class Make>
void Interval::one_by_one_across(Rounds& rounds, std::span<const std::size_t> particles,
                                 Make&& make) {
  using V = decltype(make());
  const auto count = std::int64_t(particles.size());
  asked_.threads.parallel_for(count, grain_, [&](std::int64_t begin, std::int64_t end) {
    Work done;
    V velocity = make();
    velocity.walk_by(beyond_.get());
    std::optional<Mover<V>> mover;
    if (setup_)
      mover.emplace(*setup_, velocity, integrator_, settings_.length);
    Leg<V> leg;
    for (std::int64_t item = begin; item < end; ++item) {
      const std::size_t i = particles[std::size_t(item)];
      const EffectWork before = mover ? mover->effect_work() : EffectWork{};
      begin_leg(leg, i, velocity, rounds, before);
      if (!leg.moves)
        continue;
      if (mover)
        mover->take(leg.taker ? &*leg.taker : nullptr);
      Carried carried = particles_.carried(i);
      const bool is_over = end_leg(leg, i, velocity, rounds, done, [&](std::int64_t& cell) {
        if constexpr (is_crossing<V>) {
          KeptMover beginning;
          beginning.carried = carried;
          beginning.effects = before;
          if (const auto ends = come_in_across(leg, velocity, hint(i), beginning)) {
            leg.p.x = *ends == INSITU_END_COUNT ? leg.p.x : in_frame(velocity, leg.p, cell);
            return *ends;
          }
        }
        const insitu_ending ending =
            mover ? mover->advance(leg.p, hint(i), carried, leg.to, leg.work)
                  : integrate(velocity, integrator_, leg.to, settings_.length, leg.p, leg.work,
                              leg.taker ? Visitor(*leg.taker) : Visitor());
        if (ending == INSITU_END_COUNT)
          return ending;
        cell = mover ? mover->cell() : velocity.cell();
        if (leg.taker && !mover)
          leg.taker->straight(leg.p);
        leg.p.x = in_frame(velocity, leg.p, cell);
        return ending;
      });
      if (!mover)
        continue;
      // What was done since the mark is done again.
      const bool is_marked = leg.journey->is_marked();
      if (!is_over)
        mover->set_effect_work(is_marked ? leg.journey->mark().mover.effects : before);
      if (is_over || is_marked)
        particles_.set_carried(i, is_over ? carried : leg.journey->mark().mover.carried);
    }
    const std::lock_guard lock(left_mutex_);
    result_.work += done;
    if (mover)
      result_.effects += mover->effect_work();
  });
}

/// One by one, by the flow between steps on different cells.
template <class V>
void Interval::crossing_across(Rounds& rounds, std::span<const std::size_t> particles) {
  const auto count = std::int64_t(particles.size());
  asked_.threads.parallel_for(count, grain_, [&](std::int64_t begin, std::int64_t end) {
    Work done;
    V velocity = crossing<V>(Between::either);
    velocity.walk_by(beyond_.get());
    Leg<V> leg;
    for (std::int64_t item = begin; item < end; ++item) {
      const std::size_t i = particles[std::size_t(item)];
      begin_leg(leg, i, velocity, rounds, {});
      if (!leg.moves)
        continue;
      const Visitor visitor = leg.taker ? Visitor(*leg.taker) : Visitor();
      end_leg(leg, i, velocity, rounds, done, [&](std::int64_t& cell) {
        Stepping stepping =
            integration(velocity, integrator_, leg.to, settings_.length, leg.p, leg.work, visitor);
        stepping.resume();
        const insitu_ending ending = stepping.ending();
        cell = velocity.cell();
        if (ending == INSITU_END_COUNT)
          return ending;
        if (leg.taker)
          leg.taker->straight(leg.p);
        leg.p.x = in_frame(velocity, leg.p, cell);
        return ending;
      });
    }
    const std::lock_guard lock(left_mutex_);
    result_.work += done;
  });
}

template <class V>
void Interval::cross_across(Rounds& rounds, std::span<const std::size_t> particles) {
  if (setup_)
    one_by_one_across(rounds, particles, [&] { return crossing<V>(Between::current); });
  else
    crossing_across<V>(rounds, particles);
}

/// Of all processes.
void Interval::sum_up() {
  parallel::World& world = asked_.across->world;
  Counts here;
  world.agree_after([&] { here = particles_.counts(); });
  std::int64_t sums[] = {result_.work.steps,         result_.work.rejected,
                         result_.work.forced,        result_.work.evaluations,
                         result_.effects.walk_steps, result_.effects.contacts,
                         result_.effects.pinned,     result_.travel.hops,
                         result_.travel.questions,   result_.travel.bytes};
  world.reduce(std::span(sums), parallel::Reduction::sum);
  result_.work = {sums[0], sums[1], sums[2], sums[3]};
  result_.effects = {sums[4], sums[5], sums[6]};
  result_.travel = {sums[7], sums[8], result_.travel.rounds, sums[9]};
  result_.counts = counts_of_all(world, here);
  world.agree_after([&] { check_counts(particles_, result_.counts); });
}

void Interval::carry_across(Rounds& rounds, std::span<const std::size_t> particles) {
  const bool on_chart = asked_.sampler.chart() != nullptr;
  const auto velocity = [&](auto type) {
    return [&, type] {
      return typename decltype(type)::type(here_, velocity_, earlier(), asked_.t0, asked_.t1,
                                           settings_.accuracy, effects_.drifts);
    };
  };
  if (crosses_ && on_chart)
    cross_across<CrossingVelocity<ChartVelocity>>(rounds, particles);
  else if (crosses_)
    cross_across<CrossingVelocity<DriftVelocity>>(rounds, particles);
  else if (on_chart)
    one_by_one_across(rounds, particles, velocity(std::type_identity<ChartVelocity>()));
  else if (setup_)
    one_by_one_across(rounds, particles, velocity(std::type_identity<DriftVelocity>()));
  else
    lanes_across(rounds, particles);
}

/// cells: of the current step; before: of that before a change of cells, or null.
void Interval::run_across(parallel::World& world, FarCells& cells, FarCells* before) {
  std::int64_t particles = count();
  world.reduce(std::span(&particles, 1), parallel::Reduction::sum);
  Rounds rounds(*asked_.across, settings_.accuracy, cells, before, particles_, asked_.snapshots);
  world.agree_after([&] {
    here_ = cells.sampler();
    if (before)
      before_->sampler = before->sampler();
    if (setup_)
      setup_->effects = effects_;
    beyond_ = CellsBeyond::worth(asked_.sampler, particles);
    if (crosses_)
      note(crossing<CrossingVelocity<DriftVelocity>>(Between::either));
    else
      note(MeshVelocity(here_, velocity_, earlier(), asked_.t0, asked_.t1, settings_.accuracy));
  });
  share_effects(world, asked_.sampler, asked_.threads, setup_);
  rounds.run([&](std::span<const std::size_t> some) { carry_across(rounds, some); });
  rounds.bring_home(left_);
  result_.travel = {rounds.hops(), rounds.questions(), rounds.rounds(), rounds.bytes()};
  here_ = asked_.sampler;
}

Advance Interval::run_across() {
  parallel::World& world = asked_.across->world;
  const auto fields_of = [&] {
    std::vector<FarCells::InTime> fields{{&velocity_, &earlier_}};
    add_fields(effects_, fields);
    return fields;
  };
  std::optional<FarCells> cells, before;
  make_far_cells(*asked_.across, asked_.sampler, asked_.threads, fields_of, cells);
  world.agree_after([&] {
    if (!crosses_)
      return;
    std::ranges::fill(particles_.cells, std::int64_t(-1)); // they are of the cells before
    std::vector<FarCells::InTime> fields{{&before_->velocity}};
    add_fields(before_->drifts, fields);
    before.emplace(before_->sampler, fields, FarCells::facts(before_->sampler, fields));
  });
  run_across(world, *cells, before ? &*before : nullptr);
  if (asked_.exits)
    tell_exits(world, *asked_.exits, asked_.sampler, left_, particles_);
  sum_up();
  return result_;
}

} // namespace insitu::advect
