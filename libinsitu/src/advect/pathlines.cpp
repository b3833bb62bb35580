#include "advect/pathlines.h"

#include <algorithm>
#include <string>
#include <type_traits>
#include <vector>

#include "advect/chart_velocity.h"
#include "advect/check.h"
#include "advect/mesh_velocity.h"
#include "core/status.h"

namespace insitu::advect {

Tracer::Tracer(const TracerSettings& settings, core::Memory& memory)
    : settings_(settings), particles_(memory) {
  check_settings(settings_.integrator);
}

void Tracer::seed(std::span<const math::Vec3d> points, double time) {
  particles_.seed(points, time);
}

Advance Tracer::advance(const query::Sampler& sampler, const mesh::FieldView& velocity,
                        const mesh::FieldView* earlier_velocity, double t0, double t1,
                        const core::Threads& threads) {
  check_velocity(velocity);
  if (earlier_velocity)
    check_velocity(*earlier_velocity);
  if (!(t1 >= t0))
    throw core::Error(INSITU_ERROR_ARGUMENT, "tracer: cannot advance from time " +
                                                 std::to_string(t0) + " back to " +
                                                 std::to_string(t1));

  Advance result;
  const IntegratorSettings integrator = settings_for(velocity, settings_.integrator);
  Particles& all = particles_;
  constexpr std::int64_t grain = 64;
  const std::int64_t count = std::int64_t(all.size());
  std::vector<Work> work(std::size_t((count + grain - 1) / grain));
  const auto carry = [&]<class Velocity>(std::type_identity<Velocity>) {
    const auto field = [&] {
      return Velocity(sampler, velocity, earlier_velocity, t0, t1, settings_.accuracy);
    };
    result.blended_velocity = field().blends_velocity();
    result.blended_geometry = field().blends_geometry();
    threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
      Velocity v = field();
      Work& chunk_work = work[std::size_t(begin / grain)];
      for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i) {
        if (all.endings[i] != INSITU_END_ALIVE || all.times[i] > t1)
          continue;
        State p = all.state(i);
        p.time = std::max(p.time, t0);
        const double last = all.seeding_times[i] + settings_.duration;
        v.begin(all.cells[i]);
        p.x = v.enter(p.x);
        insitu_ending ending = integrate(v, integrator, std::clamp(last, p.time, t1),
                                         settings_.length, p, chunk_work, [](const State&) {});
        if (ending == INSITU_END_ALIVE && last <= t1)
          ending = INSITU_END_EXPIRED;
        p.x = v.position(p.x);
        all.set_state(i, p, v.cell() >= 0 ? v.cell() : all.cells[i]);
        all.endings[i] = std::uint8_t(ending);
      }
    });
  };
  check_chart(sampler, integrator);
  if (sampler.chart())
    carry(std::type_identity<ChartVelocity>());
  else
    carry(std::type_identity<MeshVelocity>());
  for (const Work& w : work)
    result.work += w;
  result.counts = particles_.counts();
  return result;
}

} // namespace insitu::advect
