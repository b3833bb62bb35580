#include "advect/across/lines_across.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>

#include "advect/across/effects_across.h"
#include "advect/across/exits_across.h"
#include "advect/integrate/check.h"
#include "advect/integrate/integrations.h"
#include "advect/lanes/lanes.h"
#include "advect/lines/line_recorder.h"
#include "parallel/parcels.h"

namespace insitu::advect {

using math::Vec3d;

namespace {

/// Traces the lines of all processes; each is a particle, whose id is the line's number.
class Lines {
public:
  Lines(const Across& across, const query::Sampler& sampler, const mesh::FieldView& velocity,
        StreamlineSettings settings, std::int64_t per_seed, const core::Threads& threads,
        Particles& particles)
      : across_(across), sampler_(sampler), here_(sampler), velocity_(velocity),
        settings_(std::move(settings)), per_seed_(per_seed), threads_(threads),
        particles_(particles) {}

  LinePieces run();

private:
  /// A line's way here. Vertices: of which it is the particle.
  template <class Vertices>
  struct Leg {
    State p;
    Work work;
    OnTheWay way;
    std::vector<LineVertex> list;
    std::optional<Vertices> vertices;
    std::optional<Journey> journey;
  };
  using LaneLeg = Leg<LineVertices<LaneVelocity>>;
  using ChartLeg = Leg<LineVertices<ChartVelocity>>;
  template <class V>
  using MovedLeg = Leg<LineRecorder<V>>;
  double time_of(std::int64_t line) const {
    const bool backward = settings_.direction == Direction::backward || line % per_seed_ == 1;
    return backward ? -settings_.duration : settings_.duration;
  }
  void carry(Rounds& rounds, std::span<const std::size_t> some);
  void carry_on_chart(Rounds& rounds, std::span<const std::size_t> some);
  template <class V>
  void move(Rounds& rounds, std::span<const std::size_t> some);
  template <class L, class V>
  bool begin(L& leg, std::size_t i, V& field, const Rounds& rounds, const EffectWork& effects);
  /// run(cell): takes the line to its end, in this cell, or as far as it goes here. Returns whether
  /// it is at its end.
  template <class L, class V, class Run>
  bool end(L& leg, std::size_t i, const V& field, Rounds& rounds, Run&& run);
  template <class L>
  void keep(const L& leg, std::int64_t line);
  void run(parallel::World& world, FarCells& cells);
  void send_vertices(parallel::World& world, const FarCells& cells);
  void sum_up();

  const Across& across_;
  const query::Sampler& sampler_;
  query::Sampler here_;
  mesh::FieldView velocity_;
  StreamlineSettings settings_;
  const std::int64_t per_seed_;
  const core::Threads& threads_;
  Particles& particles_;
  std::unique_ptr<const CellsBeyond> beyond_;
  std::optional<EffectSetup> setup_; ///< under effects
  std::mutex mutex_;
  std::vector<LeftAt> left_;
  LinePieces result_;
};

/// Returns whether the line goes on here.
template <class L, class V>
bool Lines::begin(L& leg, std::size_t i, V& field, const Rounds& rounds,
                  const EffectWork& effects) {
  if (particles_.endings[i] != INSITU_END_ALIVE)
    return false;
  leg.way = rounds.way_of(i);
  leg.work = {};
  leg.p = {};
  const WayMark& mark = leg.way.mark;
  field.begin(-1);
  if (leg.way.is_marked) {
    leg.p = mark.p;
    field.enter_as(mark.field);
  } else {
    leg.p.x = field.enter(particles_.positions[i]);
  }
  leg.list.clear();
  if constexpr (std::is_same_v<L, MovedLeg<V>>)
    leg.vertices.emplace(field, here_, settings_, setup_->sides, leg.list);
  else
    leg.vertices.emplace(field, here_, settings_, leg.list);
  leg.journey.emplace(rounds.homes());
  if (leg.way.is_marked) {
    leg.vertices->go_on_from(mark.recorder);
    leg.journey->begin(mark, leg.way.stays, leg.p, leg.work, &*leg.vertices, effects);
  } else {
    leg.journey->begin(leg.p, leg.work, &*leg.vertices);
  }
  field.travel_by(&*leg.journey);
  return true;
}

/// What there is of the line here is a piece of it.
template <class L>
void Lines::keep(const L& leg, std::int64_t line) {
  const std::lock_guard lock(mutex_);
  result_.pieces.push_back({line, leg.way.hops, leg.vertices->first(), leg.list});
}

template <class L, class V, class Run>
bool Lines::end(L& leg, std::size_t i, const V& field, Rounds& rounds, Run&& run) {
  const Journey& journey = *leg.journey;
  const std::int64_t line = particles_.ids[i];
  Work done;
  bool is_over = false;
  const auto goes_on = [&] {
    const OnTheWay way = leg.way.after(journey);
    if (!way.is_marked)
      return way;
    leg.vertices->go_on_from(way.mark.recorder);
    keep(leg, line);
    done = way.mark.work;
    State at = way.mark.p;
    at.x = field.position_as(way.mark.field, at.x);
    particles_.set_state(i, at, way.mark.cell);
    return way;
  };
  try {
    std::int64_t cell = -1;
    const insitu_ending ending = run(cell);
    is_over = ending != INSITU_END_COUNT;
    if (!is_over) {
      rounds.moves(i, goes_on());
    } else {
      keep(leg, line);
      done = leg.work;
      const bool is_off = leg.list.empty() && leg.vertices->first() == 0; // where it was seeded
      if (!is_off)
        leg.p.x = field.position(leg.p.x);
      else
        leg.p.x = particles_.positions[i];
      particles_.set_state(i, leg.p, cell);
      particles_.endings[i] = std::uint8_t(ending);
      const bool seeded = ending == INSITU_END_SEED_OUTSIDE;
      if (settings_.exits && (seeded || ending == INSITU_END_LEFT)) {
        const bool any = !leg.list.empty() && !seeded;
        const std::lock_guard lock(mutex_);
        left_.push_back({i, any ? leg.list.back().point : leg.p.x,
                         any ? leg.list.back().cell : cell, leg.p.exit_normal, 1.0, seeded});
      }
    }
  } catch (const query::Elsewhere& at) {
    rounds.waits(i, goes_on(), at);
  }
  const std::lock_guard lock(mutex_);
  result_.work += done;
  return is_over;
}

/// By the velocity alone.
void Lines::carry(Rounds& rounds, std::span<const std::size_t> some) {
  const auto count = std::int64_t(some.size());
  const std::int64_t grain = std::clamp<std::int64_t>(count / (4 * threads_.count()), 16, 1024);
  threads_.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<LaneLeg> legs(
        std::size_t(std::min<std::int64_t>(LaneBatch::lane_count, end - begin)));
    run_lanes(
        here_, begin, end,
        [&](std::deque<LaneVelocity>& to) {
          to.emplace_back(here_, velocity_, nullptr, 0.0, 0.0, settings_.accuracy)
              .walk_by(beyond_.get());
        },
        [&](std::int64_t item, std::size_t slot, LaneVelocity& field) -> Stepping {
          LaneLeg& leg = legs[slot];
          const std::size_t i = some[std::size_t(item)];
          if (!this->begin(leg, i, field, rounds, {}))
            return {};
          const Visitor visitor =
              leg.vertices->is_even() ? Visitor(leg.vertices->even()) : Visitor(*leg.vertices);
          return integration(field, settings_.integrator, time_of(particles_.ids[i]),
                             settings_.length, leg.p, leg.work, visitor);
        },
        [&](std::int64_t item, std::size_t slot, const LaneVelocity& field,
            const Stepping& stepping) {
          LaneLeg& leg = legs[slot];
          this->end(leg, some[std::size_t(item)], field, rounds, [&](std::int64_t& cell) {
            const insitu_ending ending = stepping.ending();
            cell = field.cell();
            return ending == INSITU_END_COUNT ? ending : leg.vertices->finish(leg.p, ending);
          });
        });
  });
}

/// On a chart: one by one.
void Lines::carry_on_chart(Rounds& rounds, std::span<const std::size_t> some) {
  const auto count = std::int64_t(some.size());
  const std::int64_t grain = std::clamp<std::int64_t>(count / (4 * threads_.count()), 16, 1024);
  threads_.parallel_for(count, grain, [&](std::int64_t first, std::int64_t last) {
    ChartVelocity field(here_, velocity_, nullptr, 0.0, 0.0, settings_.accuracy);
    field.walk_by(beyond_.get());
    ChartLeg leg;
    for (std::int64_t item = first; item < last; ++item) {
      const std::size_t i = some[std::size_t(item)];
      if (!begin(leg, i, field, rounds, {}))
        continue;
      const Visitor visitor =
          leg.vertices->is_even() ? Visitor(leg.vertices->even()) : Visitor(*leg.vertices);
      end(leg, i, field, rounds, [&](std::int64_t& cell) {
        const insitu_ending ending =
            integrate(field, settings_.integrator, time_of(particles_.ids[i]), settings_.length,
                      leg.p, leg.work, visitor);
        cell = field.cell();
        return ending == INSITU_END_COUNT ? ending : leg.vertices->finish(leg.p, ending);
      });
    }
  });
}

/// Under effects.
template <class V>
void Lines::move(Rounds& rounds, std::span<const std::size_t> some) {
  const auto count = std::int64_t(some.size());
  const std::int64_t grain = std::clamp<std::int64_t>(count / (4 * threads_.count()), 16, 1024);
  threads_.parallel_for(count, grain, [&](std::int64_t first, std::int64_t last) {
    V field(here_, velocity_, nullptr, 0.0, 0.0, settings_.accuracy, setup_->effects.drifts);
    field.walk_by(beyond_.get());
    Mover<V> mover(*setup_, field, settings_.integrator, settings_.length);
    MovedLeg<V> leg;
    for (std::int64_t item = first; item < last; ++item) {
      const std::size_t i = some[std::size_t(item)];
      const EffectWork before = mover.effect_work();
      if (!begin(leg, i, field, rounds, before))
        continue;
      mover.take(&*leg.vertices);
      Carried carried;
      carried.id = particles_.ids[i];
      carried.velocity.x = std::numeric_limits<double>::quiet_NaN();
      const bool is_over = end(leg, i, field, rounds, [&](std::int64_t& cell) {
        const insitu_ending ending =
            mover.advance(leg.p, -1, carried, time_of(carried.id), leg.work);
        cell = mover.cell();
        return ending == INSITU_END_COUNT ? ending : leg.vertices->finish(leg.p, cell, ending);
      });
      if (!is_over)
        mover.set_effect_work(leg.journey->is_marked() ? leg.journey->mark().mover.effects
                                                       : before);
    }
  });
}

void Lines::sum_up() {
  std::int64_t sums[] = {result_.work.steps, result_.work.rejected, result_.work.forced,
                         result_.work.evaluations};
  across_.world.reduce(std::span(sums), parallel::Reduction::sum);
  result_.work = {sums[0], sums[1], sums[2], sums[3]};
  Counts here;
  across_.world.agree_after([&] { here = particles_.counts(); });
  result_.counts = counts_of_all(across_.world, here);
  across_.world.agree_after([&] { check_counts(particles_, result_.counts); });
}

/// Vertices in cells that are not here any more once the lines are made go to who owns these.
void Lines::send_vertices(parallel::World& world, const FarCells& cells) {
  struct Sent {
    LineVertex vertex;
    CellName cell;
    std::int64_t piece, number;
  };
  std::vector<parallel::Parcel> parcels;
  world.agree_after([&] {
    std::vector<std::vector<Sent>> to(std::size_t(world.size()));
    for (std::size_t p = 0; p < result_.pieces.size(); ++p)
      for (std::size_t v = 0; v < result_.pieces[p].vertices.size(); ++v) {
        LineVertex& vertex = result_.pieces[p].vertices[v];
        if (vertex.cell < 0 || !cells.is_far(vertex.cell))
          continue;
        const CellName name = cells.homes().name(vertex.cell);
        vertex.cell = -1;
        to[std::size_t(name.rank)].push_back({vertex, name, std::int64_t(p), std::int64_t(v)});
      }
    parcels = parallel::parcels_of(to);
  });
  parcels = world.exchange(parcels);
  world.agree_after([&] {
    for (const parallel::Parcel& parcel : parcels)
      for (const Sent& sent : parallel::items_of<Sent>(parcel.bytes)) {
        LineVertex vertex = sent.vertex;
        vertex.cell = across_.homes.find(sent.cell);
        result_.of_others.push_back({parcel.rank, sent.piece, sent.number, vertex});
      }
  });
}

void Lines::run(parallel::World& world, FarCells& cells) {
  Rounds rounds(across_, settings_.accuracy, cells, nullptr, particles_, nullptr);
  world.agree_after([&] {
    here_ = cells.sampler();
    if (setup_)
      setup_->effects = settings_.effects;
    beyond_ = CellsBeyond::worth(sampler_, particles_.seeded());
  });
  share_effects(world, sampler_, threads_, setup_);
  const bool on_chart = sampler_.chart() != nullptr;
  rounds.run([&](std::span<const std::size_t> some) {
    if (setup_)
      on_chart ? move<ChartVelocity>(rounds, some) : move<DriftVelocity>(rounds, some);
    else
      on_chart ? carry_on_chart(rounds, some) : carry(rounds, some);
  });
  rounds.bring_home(left_);
  send_vertices(world, cells);
  here_ = sampler_;
}

LinePieces Lines::run() {
  parallel::World& world = across_.world;
  const auto fields_of = [&] {
    if (settings_.effects.any())
      setup_.emplace(settings_.effects, sampler_, threads_);
    std::vector<FarCells::InTime> fields{{&velocity_}};
    add_fields(settings_.effects, fields);
    return fields;
  };
  std::optional<FarCells> cells;
  make_far_cells(across_, sampler_, threads_, fields_of, cells);
  run(world, *cells);
  if (settings_.exits)
    tell_exits(world, *settings_.exits, sampler_, left_, particles_);
  world.agree_after([&] {
    for (std::size_t i = 0; i < particles_.size(); ++i)
      if (particles_.endings[i] != Particles::gone)
        result_.ends.push_back({particles_.ids[i], particles_.endings[i]});
  });
  sum_up();
  return std::move(result_);
}

} // namespace

LinePieces trace_lines_across(const Across& across, const query::Sampler& sampler,
                              const mesh::FieldView& velocity, std::span<const Vec3d> seeds,
                              const StreamlineSettings& settings, const core::Threads& threads,
                              core::Memory& memory) {
  StreamlineSettings steady = settings;
  std::vector<Vec3d> starts;
  const std::int64_t per_seed = settings.direction == Direction::both ? 2 : 1;
  across.world.agree_after([&] {
    check_velocity(velocity, sampler.mesh());
    check_settings(settings.integrator);
    check_line_effects(settings);
    steady.integrator = settings_for(velocity, settings.integrator);
    steady.integrator.ends_at_rest = true;
    for (const Vec3d& seed : seeds)
      starts.insert(starts.end(), std::size_t(per_seed), seed);
  });
  Particles particles(memory);
  seed_across(particles, starts, 0.0, sampler, settings.accuracy, across);
  return Lines(across, sampler, velocity, steady, per_seed, threads, particles).run();
}

} // namespace insitu::advect
