// Tracers over several processes.
#include <algorithm>
#include <bit>
#include <optional>
#include <string>
#include <vector>

#include "advect/lines/interval.h"
#include "advect/pathlines.h"
#include "core/status.h"

namespace insitu::advect {

namespace {

/// Sets the flags of points that are this process's, a bit each; the others' are 0.
void find_own(std::span<const math::Vec3d> points, const query::Sampler& sampler,
              insitu_accuracy accuracy, const Homes& homes, std::span<std::int64_t> flags) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (const query::Location at = sampler.locate(points[i], -1, {accuracy, 1.0, false});
        at && homes.is_own(at.cell))
      flags[i / 64] |= std::int64_t(std::uint64_t(1) << (i % 64));
}

} // namespace

void seed_across(Particles& particles, std::span<const math::Vec3d> points, double time,
                 const query::Sampler& sampler, insitu_accuracy accuracy, const Across& across) {
  parallel::World& world = across.world;
  constexpr std::size_t slice = 1'000'000;
  for (std::size_t first = 0; first < points.size(); first += slice) {
    const auto part = points.subspan(first, std::min(slice, points.size() - first));
    std::vector<std::int64_t> own, all;
    world.agree_after([&] {
      own.resize((part.size() + 63) / 64, 0);
      find_own(part, sampler, accuracy, across.homes, own);
      all = own;
    });
    // A point has one owner, so the sum of its bits does not carry.
    world.reduce(std::span(all), parallel::Reduction::sum);
    std::int64_t found[2] = {};
    for (const std::int64_t bits : own)
      found[0] += std::popcount(std::uint64_t(bits));
    for (const std::int64_t bits : all)
      found[1] += std::popcount(std::uint64_t(bits));
    world.reduce(std::span(found, 1), parallel::Reduction::sum);
    world.agree_after([&] {
      if (found[0] != found[1])
        throw core::Error(INSITU_ERROR_INTERNAL, "tracer: processes own " +
                                                     std::to_string(found[0]) + " of the seeds, " +
                                                     std::to_string(found[1]) + " of them once");
      std::vector<std::uint8_t> keeps(part.size());
      for (std::size_t i = 0; i < part.size(); ++i) {
        const auto is_in = [&](const std::vector<std::int64_t>& bits) {
          return (std::uint64_t(bits[i / 64]) >> (i % 64) & 1U) != 0;
        };
        keeps[i] = is_in(own) || (world.is_root() && !is_in(all));
      }
      particles.seed(part, time, keeps);
    });
  }
}

void Tracer::seed(std::span<const math::Vec3d> points, double time, const query::Sampler& sampler,
                  const Across& across) {
  seed_across(particles_, points, time, sampler, settings_.accuracy, across);
}

Advance Tracer::advance(const Across& across, const query::Sampler& sampler,
                        const mesh::FieldView& velocity, const EarlierSteps& earlier_velocity,
                        double t0, double t1, const core::Threads& threads, Snapshots* snapshots,
                        const StepBefore* before) {
  EarlierSteps steps;
  std::optional<Interval> interval;
  across.world.agree_after([&] {
    check_interval(t0, t1);
    steps = check_fields(velocity, earlier_velocity, before);
    interval.emplace(Interval::Asked{sampler, velocity, steps, t0, t1, threads, snapshots, before,
                                     exits_, &across},
                     settings_, effects_, particles_);
  });
  return interval->run_across();
}

} // namespace insitu::advect
