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
    std::vector<std::uint8_t> keeps;
    world.agree_after([&] {
      if (found[0] != found[1])
        throw core::Error(INSITU_ERROR_INTERNAL, "tracer: processes own " +
                                                     std::to_string(found[0]) + " of the seeds, " +
                                                     std::to_string(found[1]) + " of them once");
      keeps.resize(part.size());
      for (std::size_t i = 0; i < part.size(); ++i) {
        const auto is_in = [&](const std::vector<std::int64_t>& bits) {
          return (std::uint64_t(bits[i / 64]) >> (i % 64) & 1U) != 0;
        };
        keeps[i] = is_in(own) || (world.is_root() && !is_in(all));
      }
      particles.reserve(std::size_t(std::ranges::count(keeps, 1)));
    });
    particles.seed(part, time, keeps); // by all, or by none
  }
}

void bring_to_cells(Particles& particles, const query::Sampler& sampler, insitu_accuracy accuracy,
                    const Across& across, const core::Threads& threads) {
  const auto no_fields = [] { return std::vector<FarCells::InTime>(); };
  std::optional<FarCells> cells;
  make_far_cells(across, sampler, threads, no_fields, cells);
  const query::Sampler& here = cells->sampler();
  Rounds rounds(across, accuracy, *cells, nullptr, particles, nullptr);
  const auto find = [&](std::size_t i) {
    if (particles.endings[i] != INSITU_END_ALIVE || particles.fresh[i])
      return; // what is fresh is where it is to be
    OnTheWay way = rounds.way_of(i);
    try {
      const query::Location at = here.locate(particles.positions[i], -1, {accuracy});
      if (at && !rounds.homes().is_own(at.cell)) {
        way.mark.to = rounds.homes().name(at.cell);
        rounds.moves(i, way);
      }
    } catch (const query::Elsewhere& at) {
      rounds.waits(i, way, at);
    }
  };
  rounds.run([&](std::span<const std::size_t> some) {
    threads.parallel_for(std::int64_t(some.size()), 256, [&](std::int64_t begin, std::int64_t end) {
      for (const std::size_t i : some.subspan(std::size_t(begin), std::size_t(end - begin)))
        find(i);
    });
  });
}

Counts counts_of_all(parallel::World& world, const Counts& here) {
  std::vector<std::int64_t> sums{here.seeded};
  sums.insert(sums.end(), here.by_ending.begin(), here.by_ending.end());
  world.reduce(std::span(sums), parallel::Reduction::sum);
  Counts all;
  all.seeded = sums[0];
  std::copy(sums.begin() + 1, sums.end(), all.by_ending.begin());
  return all;
}

void check_counts(const Particles& here, const Counts& all) {
  if (all.seeded != here.seeded() || all.sum() != all.seeded)
    throw core::Error(INSITU_ERROR_INTERNAL, "tracer: " + std::to_string(here.seeded()) +
                                                 " particles were seeded, but all processes have " +
                                                 std::to_string(all.sum()));
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
    steps = check_fields(sampler, velocity, earlier_velocity, before);
    interval.emplace(Interval::Asked{sampler, velocity, steps, t0, t1, threads, snapshots, before,
                                     exits_, &across},
                     settings_, effects_, particles_);
  });
  return interval->run_across();
}

Counts Tracer::follow(const Across& across, const query::Sampler& sampler, bool same_cells,
                      double t0, double t1, const core::Threads& threads, Snapshots* snapshots) {
  parallel::World& world = across.world;
  std::int64_t others = !same_cells;
  world.reduce(std::span(&others, 1), parallel::Reduction::greatest);
  if (others)
    bring_to_cells(particles_, sampler, settings_.accuracy, across, threads);
  Counts counts;
  world.agree_after([&] { counts = follow(sampler, !others, t0, t1, threads, snapshots); });
  counts = counts_of_all(world, counts);
  world.agree_after([&] { check_counts(particles_, counts); });
  return counts;
}

} // namespace insitu::advect
