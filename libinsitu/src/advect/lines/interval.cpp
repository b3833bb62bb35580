#include "advect/lines/interval.h"

#include <algorithm>
#include <cmath>

#include "advect/field/owners.h"
#include "advect/integrate/check.h"
#include "advect/lines/interval_one_by_one.h"

namespace insitu::advect {

namespace {

/// Particles of a chunk: enough to fill lanes again and again, if there are that many.
std::int64_t grain_of(std::int64_t particles, const core::Threads& threads) {
  if (threads.count() == 1)
    return 1 << 14;
  return std::clamp<std::int64_t>(particles / (4 * threads.count()), 16, 1024);
}

} // namespace

Interval::Interval(const Asked& asked, const TracerSettings& settings, const Effects& effects,
                   Particles& particles)
    : asked_(asked), settings_(settings), effects_(effects), velocity_(asked.velocity),
      earlier_(asked.earlier.fields.begin(), asked.earlier.fields.end()), particles_(particles),
      crosses_(asked.before && asked.t1 != asked.t0),
      integrator_(settings_for(asked.velocity, settings.integrator)),
      grain_(grain_of(std::int64_t(particles.size()), asked.threads)), here_(asked.sampler) {
  if (asked.before)
    before_ = *asked.before;
  // On a geodetic mesh and between cells drifts are the velocity's, which integrate() alone
  // follows.
  if (asked.sampler.chart() || crosses_ ? effects.displaces() : effects.any())
    setup_.emplace(effects, asked.sampler, asked.threads);
  if (asked.snapshots)
    asked.snapshots->begin(particles.size(), settings.backward);
  work_.resize(std::size_t((count() + grain_ - 1) / grain_));
  effect_work_.resize(setup_ ? work_.size() : 0);
  if (!asked.across)
    beyond_ = CellsBeyond::worth(asked.sampler, count());
}

bool Interval::prepare(std::size_t i, State& p, double& to) const {
  if (particles_.endings[i] != INSITU_END_ALIVE || is_before(asked_.t1, particles_.times[i]))
    return false;
  p = particles_.state(i);
  if (is_before(p.time, asked_.t0))
    p.time = asked_.t0;
  to = at_age(particles_.seeding_times[i], settings_.duration);
  if (is_before(asked_.t1, to))
    to = asked_.t1;
  if (is_before(to, p.time))
    to = p.time;
  return true;
}

insitu_ending Interval::store(std::size_t i, const State& p, std::int64_t cell,
                              insitu_ending ending, double geometry_alpha) {
  const double t1 = asked_.t1, seeded = particles_.seeding_times[i];
  if (ending == INSITU_END_ALIVE && !is_before(t1, at_age(seeded, settings_.duration)))
    ending = INSITU_END_EXPIRED;
  if (ending == INSITU_END_ALIVE && crosses_ && cell == -1)
    ending = is_before(seeded, t1) ? INSITU_END_LEFT // where there were cells before
                                   : INSITU_END_SEED_OUTSIDE;
  if (ending == INSITU_END_ALIVE && effects_.removes) {
    const query::Location here =
        owner_of(here_, beyond_.get(), cell, p.x, {settings_.accuracy, geometry_alpha});
    if (here && effects_.is_removed(here_, here, p.x, std::abs(p.time - seeded)))
      ending = INSITU_END_REMOVED;
  }
  if (ending != INSITU_END_ALIVE && ending != INSITU_END_LEFT && cell >= 0 && moves_in_lanes() &&
      result_.blended_geometry) // it may be another one of those at a face
    if (const query::Location at =
            owner_of(here_, beyond_.get(), cell, p.x, {settings_.accuracy, geometry_alpha}))
      cell = at.cell;
  particles_.set_state(i, p, cell >= 0 || crosses_ ? cell : particles_.cells[i]);
  particles_.endings[i] = std::uint8_t(ending);
  if (asked_.exits && (ending == INSITU_END_LEFT || ending == INSITU_END_SEED_OUTSIDE)) {
    const std::lock_guard lock(left_mutex_);
    left_.push_back({i, p.x, cell, p.exit_normal, geometry_alpha, ending != INSITU_END_LEFT});
  }
  return ending;
}

/// One by one.
void Interval::run_on_same_cells() {
  const auto velocity = [&](auto type) {
    return [&, type] {
      return
          typename decltype(type)::type(asked_.sampler, asked_.velocity, asked_.earlier, asked_.t0,
                                        asked_.t1, settings_.accuracy, effects_.drifts);
    };
  };
  if (asked_.sampler.chart())
    carry(velocity(std::type_identity<ChartVelocity>()));
  else
    carry(velocity(std::type_identity<DriftVelocity>()));
}

Advance Interval::run() {
  if (crosses_)
    run_crossing();
  else if (moves_in_lanes())
    run_in_lanes();
  else
    run_on_same_cells();
  for (const LeftAt& at : left_)
    particles_.endings[at.particle] = std::uint8_t(asked_.exits->ending(asked_.sampler, at));
  for (const EffectWork& w : effect_work_)
    result_.effects += w;
  for (const Work& w : work_)
    result_.work += w;
  result_.counts = particles_.counts();
  return result_;
}

} // namespace insitu::advect
