#include "advect/pathlines.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "advect/effects/mover.h"
#include "advect/field/chart_velocity.h"
#include "advect/field/mesh_velocity.h"
#include "advect/integrate/check.h"
#include "advect/integrate/integrations.h"
#include "advect/lanes/lanes.h"
#include "advect/lines/snapshots.h"
#include "core/status.h"
#include "query/walk/attached.h"
#include "query/walk/beside_mesh.h"

namespace insitu::advect {

namespace {

/// Where integrate() alone moves the particles.
struct NoMover {};

/// Particles of a chunk: enough to fill lanes again and again, if there are that many.
std::int64_t grain_of(std::int64_t particles, const core::Threads& threads) {
  return std::clamp<std::int64_t>(particles / (4 * threads.count()), 16, 1024);
}

} // namespace

void Tracer::check_interval(double t0, double t1) const {
  if (std::isnan(t0) || std::isnan(t1) || is_before(t1, t0))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("tracer: ") +
                          (settings_.backward ? "backwards, it cannot go from time "
                                              : "cannot advance from time ") +
                          std::to_string(t0) + (settings_.backward ? " on to " : " back to ") +
                          std::to_string(t1));
}

Tracer::Tracer(const TracerSettings& settings, core::Memory& memory)
    : settings_(settings), particles_(memory) {
  check_settings(settings_.integrator);
  if (settings_.attached && settings_.backward)
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "tracer: particles that go with the mesh's material have no direction");
  if (settings_.attached)
    particles_.keep_parametric();
}

void Tracer::set_effects(const Effects& effects) {
  check_effects(effects);
  if (settings_.backward && (effects.diffusion || effects.inertia))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("tracer: backwards, particles have no ") +
                          (effects.diffusion ? "random walk, which has no way back"
                                             : "inertia: every error would grow without bound"));
  if (settings_.attached && (effects.displaces() || !effects.drifts.empty()))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "tracer: nothing else moves particles that go with the mesh's material");
  effects_ = effects;
  if (effects_.diffusion)
    particles_.keep_walk_steps();
  if (effects_.inertia)
    particles_.keep_velocities();
}

void Tracer::seed(std::span<const math::Vec3d> points, double time) {
  particles_.seed(points, time);
}

Advance Tracer::advance(const query::Sampler& sampler, const mesh::FieldView& velocity,
                        const EarlierSteps& earlier_velocity, double t0, double t1,
                        const core::Threads& threads, Snapshots* snapshots,
                        const StepBefore* before) {
  check_velocity(velocity);
  for (const mesh::FieldView& earlier : earlier_velocity.fields)
    check_velocity(earlier);
  check_interval(t0, t1);
  if (before)
    check_velocity(before->velocity);
  const bool crosses = before && t1 != t0;
  EarlierSteps steps = earlier_velocity;
  steps.fields = steps.fields.first(
      std::min(steps.fields.size(), std::size_t(steps_of(settings_.time_interpolation) - 1)));

  Advance result;
  const IntegratorSettings integrator = settings_for(velocity, settings_.integrator);
  // On a geodetic mesh and between cells drifts are the velocity's, which integrate() alone
  // follows.
  const std::optional<EffectSetup> setup =
      (sampler.chart() || crosses ? effects_.displaces() : effects_.any())
          ? std::optional<EffectSetup>(std::in_place, effects_, sampler, threads)
          : std::nullopt;
  Particles& all = particles_;
  const std::int64_t count = std::int64_t(all.size());
  const std::int64_t grain = grain_of(count, threads);
  if (snapshots)
    snapshots->begin(all.size(), settings_.backward);
  std::vector<Work> work(std::size_t((count + grain - 1) / grain));
  std::vector<EffectWork> effect_work(setup ? work.size() : 0);
  // The particle's state if it moves, and until when.
  const auto prepare = [&](std::size_t i, State& p, double& to) {
    if (all.endings[i] != INSITU_END_ALIVE || is_before(t1, all.times[i]))
      return false;
    p = all.state(i);
    if (is_before(p.time, t0))
      p.time = t0;
    to = at_age(all.seeding_times[i], settings_.duration);
    if (is_before(t1, to))
      to = t1;
    if (is_before(to, p.time))
      to = p.time;
    return true;
  };
  std::mutex left_mutex;
  std::vector<LeftAt> left;
  const auto store = [&](std::size_t i, const State& p, std::int64_t cell, insitu_ending ending,
                         double geometry_alpha) {
    if (ending == INSITU_END_ALIVE &&
        !is_before(t1, at_age(all.seeding_times[i], settings_.duration)))
      ending = INSITU_END_EXPIRED;
    if (ending == INSITU_END_ALIVE && crosses && cell < 0)
      ending = is_before(all.seeding_times[i], t1)
                   ? INSITU_END_LEFT // where there were cells before
                   : INSITU_END_SEED_OUTSIDE;
    if (ending == INSITU_END_ALIVE && effects_.removes) {
      const query::Location here = sampler.locate(p.x, cell, {settings_.accuracy, geometry_alpha});
      if (here && effects_.removes(here, p.x, std::abs(p.time - all.seeding_times[i])))
        ending = INSITU_END_REMOVED;
    }
    all.set_state(i, p, cell >= 0 || crosses ? cell : all.cells[i]);
    all.endings[i] = std::uint8_t(ending);
    if (exits_ && (ending == INSITU_END_LEFT || ending == INSITU_END_SEED_OUTSIDE)) {
      const std::lock_guard lock(left_mutex);
      left.push_back({i, p.x, cell, p.exit_normal, geometry_alpha, ending != INSITU_END_LEFT});
    }
    return ending;
  };
  // A position in the mesh's frame: where rounding on the way from a chart has it beyond a wall, in
  // the mesh.
  const auto in_frame = [&](const auto& v, const State& p, std::int64_t cell) {
    math::Vec3d x = v.position(p.x);
    const query::LocateOptions options{settings_.accuracy, v.geometry_alpha(p.time)};
    if (sampler.chart() && cell >= 0 && !(x == p.x) && !sampler.locate(x, cell, options))
      (void)query::bring_inside(sampler, x, query::rounding_in(sampler.mesh(), cell, options.alpha),
                                options);
    return x;
  };
  const std::unique_ptr<const CellsBeyond> beyond = CellsBeyond::worth(sampler, count);
  const Sides none;
  const auto between = [&]<class V>(Between what, std::type_identity<V>) {
    return CrossingVelocity<V>(sampler, velocity, *before, t0, t1, settings_.accuracy,
                               effects_.drifts, what);
  };
  // Where only the step before has cells yet, and so there are no walls, a particle goes with the
  // flow until the current ones, whose velocity is v, hold it. How it ends before, if it does.
  const auto come_in = [&]<class V>(CrossingVelocity<V>& v, State& p, std::size_t i, double to,
                                    Work& chunk_work, Recorder* taker) {
    std::optional<insitu_ending> ends;
    if (effects_.inertia || sampler.locate(v.position(p.x), -1, {settings_.accuracy}))
      return ends;
    CrossingVelocity<V> either = between(Between::either, std::type_identity<V>());
    either.begin(all.cells[i]);
    either.go_by(v);
    struct UntilIn {
      CrossingVelocity<V>&either, &v;
      Recorder* taker;
      bool operator()(const State& s) const {
        v.go_by(either);
        if (taker)
          (*taker)(s);
        return either.cell() < 0;
      }
      bool operator()(const State& s, const DenseStep& path) const {
        v.go_by(either);
        if (taker)
          (*taker)(s, path);
        return either.cell() < 0;
      }
    };
    const insitu_ending ending = integrate(either, integrator, to, settings_.length, p, chunk_work,
                                           UntilIn{either, v, taker});
    v.go_by(either);
    if (either.cell() < 0 || (ending != INSITU_END_REMOVED && ending != INSITU_END_ALIVE))
      ends = ending;
    return ends;
  };
  // One by one: make() gives a thread its field of velocities; begin_chunk(field) what moves
  // particles in it.
  const auto carry = [&](auto&& make, auto&& begin_chunk) {
    result.velocity_steps = make().velocity_steps();
    result.blended_velocity = result.velocity_steps > 1;
    result.blended_geometry = make().blends_geometry();
    threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
      auto v = make();
      v.walk_by(beyond.get());
      auto mover = begin_chunk(v);
      Work& chunk_work = work[std::size_t(begin / grain)];
      for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i) {
        State p;
        double to = 0.0;
        if (!prepare(i, p, to))
          continue;
        insitu_ending ending = INSITU_END_ALIVE;
        std::int64_t cell = -1;
        std::optional<SnapshotTaker<std::remove_reference_t<decltype(v)>>> taker;
        if constexpr (!std::is_same_v<decltype(mover), NoMover>) {
          p.x = v.enter(p.x);
          if (snapshots)
            taker.emplace(*snapshots, i, p, v, sampler, settings_.accuracy, setup->sides);
          mover->take(taker ? &*taker : nullptr);
          std::optional<insitu_ending> ends;
          if constexpr (requires { come_in(v, p, i, to, chunk_work, nullptr); })
            ends = come_in(v, p, i, to, chunk_work, taker ? &*taker : nullptr);
          if (ends) {
            ending = *ends;
          } else {
            Carried carried = all.carried(i);
            ending = mover->advance(p, all.cells[i], carried, to, chunk_work);
            all.set_carried(i, carried);
            cell = mover->cell();
          }
          p.x = in_frame(v, p, cell);
        } else {
          v.begin(all.cells[i]);
          p.x = v.enter(p.x);
          if (snapshots) {
            taker.emplace(*snapshots, i, p, v, sampler, settings_.accuracy, none);
            ending = integrate(v, integrator, to, settings_.length, p, chunk_work, *taker);
            taker->straight(p);
          } else {
            ending = integrate(v, integrator, to, settings_.length, p, chunk_work, Visitor());
          }
          cell = v.cell();
          p.x = in_frame(v, p, cell);
        }
        ending = store(i, p, cell, ending, v.geometry_alpha(p.time));
        if (taker && ending != INSITU_END_ALIVE)
          taker->ended(p);
      }
      if constexpr (!std::is_same_v<decltype(mover), NoMover>)
        effect_work[std::size_t(begin / grain)] = mover->effect_work();
    });
  };
  // Many at a time, by the flow alone.
  const auto carry_in_lanes = [&] {
    threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
      Work& chunk_work = work[std::size_t(begin / grain)];
      State states[LaneBatch::lane_count];
      std::optional<SnapshotTaker<LaneVelocity>> takers[LaneBatch::lane_count];
      run_lanes(
          sampler, begin, end,
          [&](std::deque<LaneVelocity>& to) {
            to.emplace_back(sampler, velocity, steps, t0, t1, settings_.accuracy)
                .walk_by(beyond.get());
          },
          [&](std::int64_t i, std::size_t slot, LaneVelocity& v) -> Stepping {
            State& p = states[slot];
            double to = 0.0;
            if (!prepare(std::size_t(i), p, to))
              return {};
            v.begin(all.cells[std::size_t(i)]);
            if (!snapshots)
              return integration(v, integrator, to, settings_.length, p, chunk_work, Visitor());
            takers[slot].emplace(*snapshots, std::size_t(i), p, v, sampler, settings_.accuracy,
                                 none);
            return integration(v, integrator, to, settings_.length, p, chunk_work,
                               Visitor(*takers[slot]));
          },
          [&](std::int64_t i, std::size_t slot, LaneVelocity& v, insitu_ending ending) {
            const State& p = states[slot];
            ending = store(std::size_t(i), p, v.cell(), ending, v.geometry_alpha(p.time));
            if (!snapshots)
              return;
            takers[slot]->straight(p);
            if (ending != INSITU_END_ALIVE)
              takers[slot]->ended(p);
          });
    });
  };
  const auto plain = [](auto&) { return NoMover{}; };
  const auto moving = [&]<class V>(V& v) {
    return std::make_unique<Mover<V>>(*setup, v, integrator, settings_.length);
  };
  const auto on_chart = [&] {
    return ChartVelocity(sampler, velocity, steps, t0, t1, settings_.accuracy, effects_.drifts);
  };
  const auto cross = [&](auto type) {
    if (setup)
      carry([&] { return between(Between::current, type); }, moving);
    else
      carry([&] { return between(Between::either, type); }, plain);
  };
  if (sampler.chart())
    check_chart_effects(effects_);
  if (crosses && sampler.chart()) {
    cross(std::type_identity<ChartVelocity>());
  } else if (crosses) {
    cross(std::type_identity<DriftVelocity>());
  } else if (sampler.chart()) {
    if (setup)
      carry(on_chart, moving);
    else
      carry(on_chart, plain);
  } else if (setup) {
    carry(
        [&] {
          return DriftVelocity(sampler, velocity, steps, t0, t1, settings_.accuracy,
                               effects_.drifts);
        },
        moving);
  } else {
    const MeshVelocity flow(sampler, velocity, steps, t0, t1, settings_.accuracy);
    result.velocity_steps = flow.velocity_steps();
    result.blended_velocity = result.velocity_steps > 1;
    result.blended_geometry = flow.blends_geometry();
    carry_in_lanes();
  }
  for (const LeftAt& at : left)
    all.endings[at.particle] = std::uint8_t(exits_->ending(sampler, at));
  for (const EffectWork& w : effect_work)
    result.effects += w;
  for (const Work& w : work)
    result.work += w;
  result.counts = particles_.counts();
  return result;
}

namespace {

/// Particle i went straight from where it was at `begins`, in its place of its cell if that is
/// known (or began there: fresh), and came to where it is now.
void take_straight(const query::Sampler& sampler, Snapshots& snapshots, std::size_t i,
                   const Particles& all, bool fresh, const math::Vec3d& from, double begins,
                   const query::Location& place) {
  const math::Vec3d to = all.positions[i];
  const double ends = all.times[i];
  for (std::size_t k = 0; k < snapshots.times.size(); ++k) {
    const double t = snapshots.times[k];
    const bool begun = fresh ? t >= begins : t > begins;
    if (!begun || t > ends || (t == ends && all.endings[i] != INSITU_END_ALIVE))
      continue;
    const std::size_t item = snapshots.item(k, i);
    const double part = ends > begins ? (t - begins) / (ends - begins) : 1.0;
    snapshots.positions[item] = t == ends ? to : query::on_the_way(sampler, from, to, part);
    snapshots.places[item] = place;
    snapshots.present[item] = 1;
  }
}

} // namespace

Counts Tracer::follow(const query::Sampler& sampler, bool same_cells, double t0, double t1,
                      const core::Threads& threads, Snapshots* snapshots) {
  check_interval(t0, t1);
  Particles& all = particles_;
  if (snapshots)
    snapshots->begin(all.size());
  threads.parallel_for(std::int64_t(all.size()), 256, [&](std::int64_t begin, std::int64_t end) {
    for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i) {
      if (all.endings[i] != INSITU_END_ALIVE || all.times[i] > t1)
        continue;
      const math::Vec3d from = all.positions[i];
      const double begins = all.times[i], last = all.seeding_times[i] + settings_.duration;
      query::Location at{all.fresh[i] ? -1 : all.cells[i], all.parametric[i]};
      if (!query::follow(sampler, same_cells, {settings_.accuracy}, at, all.positions[i])) {
        all.endings[i] = std::uint8_t(all.fresh[i] ? INSITU_END_SEED_OUTSIDE : INSITU_END_LEFT);
        continue;
      }
      const bool fresh = all.fresh[i] != 0;
      all.fresh[i] = 0;
      all.cells[i] = at.cell;
      all.parametric[i] = at.parametric;
      all.times[i] = t1;
      if (last <= t1) { // on the straight way there
        const double part =
            t1 > begins ? std::clamp((last - begins) / (t1 - begins), 0.0, 1.0) : 1.0;
        all.positions[i] = query::on_the_way(sampler, from, all.positions[i], part);
        all.times[i] = std::max(begins, std::min(last, t1));
        all.endings[i] = INSITU_END_EXPIRED;
      }
      all.lengths[i] += sampler.chart()
                            ? query::metres_between(*sampler.chart(), from, all.positions[i])
                            : length_of(all.positions[i] - from);
      if (all.lengths[i] >= settings_.length)
        all.endings[i] = INSITU_END_EXPIRED;
      if (effects_.removes && all.endings[i] == INSITU_END_ALIVE &&
          effects_.removes(at, all.positions[i], all.times[i] - all.seeding_times[i]))
        all.endings[i] = INSITU_END_REMOVED;
      if (snapshots)
        take_straight(sampler, *snapshots, i, all, fresh, from, begins, at);
    }
  });
  return all.counts();
}

} // namespace insitu::advect
