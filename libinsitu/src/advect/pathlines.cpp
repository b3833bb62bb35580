#include "advect/pathlines.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "advect/integrate/check.h"
#include "advect/lines/interval.h"
#include "core/status.h"
#include "query/walk/attached.h"

namespace insitu::advect {

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

EarlierSteps Tracer::check_fields(const query::Sampler& sampler, const mesh::FieldView& velocity,
                                  const EarlierSteps& earlier, const StepBefore* before) const {
  check_velocity(velocity, sampler.mesh());
  for (const mesh::FieldView& field : earlier.fields)
    check_velocity(field, sampler.mesh());
  if (before)
    check_velocity(before->velocity, before->sampler.mesh());
  EarlierSteps steps = earlier;
  steps.fields = steps.fields.first(
      std::min(steps.fields.size(), std::size_t(steps_of(settings_.time_interpolation) - 1)));
  return steps;
}

Advance Tracer::advance(const query::Sampler& sampler, const mesh::FieldView& velocity,
                        const EarlierSteps& earlier_velocity, double t0, double t1,
                        const core::Threads& threads, Snapshots* snapshots,
                        const StepBefore* before) {
  check_interval(t0, t1);
  const EarlierSteps steps = check_fields(sampler, velocity, earlier_velocity, before);
  return Interval({sampler, velocity, steps, t0, t1, threads, snapshots, before, exits_}, settings_,
                  effects_, particles_)
      .run();
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
        if (!same_cells) // it is of the cells before
          all.cells[i] = -1;
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
      all.lengths[i] += query::distance(sampler, from, all.positions[i]);
      if (all.lengths[i] >= settings_.length)
        all.endings[i] = INSITU_END_EXPIRED;
      if (effects_.removes && all.endings[i] == INSITU_END_ALIVE &&
          effects_.is_removed(sampler, at, all.positions[i], all.times[i] - all.seeding_times[i]))
        all.endings[i] = INSITU_END_REMOVED;
      if (snapshots)
        take_straight(sampler, *snapshots, i, all, fresh, from, begins, at);
    }
  });
  return all.counts();
}

} // namespace insitu::advect
