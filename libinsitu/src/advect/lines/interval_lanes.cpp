#include "advect/integrate/integrations.h"
#include "advect/lanes/lanes.h"
#include "advect/lines/interval.h"

namespace insitu::advect {

/// Many particles at a time, by the flow alone.
void Interval::run_in_lanes() {
  const auto velocity = [&](auto&& make) {
    return make(asked_.sampler, asked_.velocity, asked_.earlier, asked_.t0, asked_.t1,
                settings_.accuracy);
  };
  velocity([&](auto&&... arguments) { note(MeshVelocity(arguments...)); });
  Snapshots* const snapshots = asked_.snapshots;
  asked_.threads.parallel_for(count(), grain_, [&](std::int64_t begin, std::int64_t end) {
    Work& work = work_of(begin);
    State states[LaneBatch::lane_count];
    std::optional<SnapshotTaker<LaneVelocity>> takers[LaneBatch::lane_count];
    run_lanes(
        asked_.sampler, begin, end,
        [&](std::deque<LaneVelocity>& to) {
          velocity([&](auto&&... arguments) {
            LaneVelocity& v = to.emplace_back(arguments...);
            v.walk_by(beyond_.get());
            v.take_boundaries();
          });
        },
        [&](std::int64_t i, std::size_t slot, LaneVelocity& v) -> Stepping {
          State& p = states[slot];
          double to = 0.0;
          if (!prepare(std::size_t(i), p, to))
            return {};
          v.begin(particles_.cells[std::size_t(i)]);
          if (!snapshots)
            return integration(v, integrator_, to, settings_.length, p, work, Visitor());
          takers[slot].emplace(*snapshots, std::size_t(i), p, v, asked_.sampler, settings_.accuracy,
                               no_sides_);
          return integration(v, integrator_, to, settings_.length, p, work, Visitor(*takers[slot]));
        },
        [&](std::int64_t i, std::size_t slot, LaneVelocity& v, const Stepping& stepping) {
          const State& p = states[slot];
          const insitu_ending ending =
              store(std::size_t(i), p, v.cell(), stepping.ending(), v.geometry_alpha(p.time));
          if (!snapshots)
            return;
          takers[slot]->straight(p);
          if (ending != INSITU_END_ALIVE)
            takers[slot]->ended(p);
        });
  });
}

} // namespace insitu::advect
