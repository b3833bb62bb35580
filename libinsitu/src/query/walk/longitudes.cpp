#include "query/walk/longitudes.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <limits>

namespace insitu::query {

namespace {

constexpr int bins = 3600;
using Taken = std::bitset<bins>;

/// In which parts of a turn, from the chart's west on, there are cells.
Taken taken_by(const mesh::MeshView& mesh, const ChartImage& chart, const core::Threads& threads) {
  const double width = chart.units.turn() / bins;
  const auto bin = [&](double x) { return int(std::floor((x - chart.west) / width)); };
  Taken all;
  for (const Taken& part : over_boxes(mesh, threads, all, [&](Taken&t, const mesh::Box&cell) {
         for (int b = bin(cell.low.x); b <= bin(cell.high.x); ++b)
           t.set(std::size_t((b % bins + bins) % bins));
       }))
    all |= part;
  return all;
}

struct Reach {
  double low = std::numeric_limits<double>::infinity(), high = -low;
};

/// Of the cells, all moved by whole turns to the east of the gap.
Reach reach_of(const mesh::MeshView& mesh, double gap, double turn, const core::Threads& threads) {
  Reach all;
  for (const Reach& part : over_boxes(mesh, threads, all, [&](Reach&r, const mesh::Box&cell) {
         const double turns = turn * std::floor((cell.low.x - gap) / turn);
         r.low = std::min(r.low, cell.low.x - turns);
         r.high = std::max(r.high, cell.high.x - turns);
       })) {
    all.low = std::min(all.low, part.low);
    all.high = std::max(all.high, part.high);
  }
  return all;
}

} // namespace

std::optional<Longitudes> longitudes_of(const mesh::MeshView& mesh, const ChartImage* chart,
                                        const core::Threads& threads, parallel::World& world) {
  std::array<std::int64_t, bins> taken{};
  world.agree_after([&] {
    if (!chart)
      return;
    const Taken here = taken_by(mesh, *chart, threads);
    for (std::size_t b = 0; b < bins; ++b)
      taken[b] = here[b];
  });
  world.reduce(taken, parallel::Reduction::greatest);
  int longest = 0, gap_end = 0;
  for (int b = 0, run = 0; b < 2 * bins; ++b) {
    run = taken[std::size_t(b % bins)] ? 0 : run + 1;
    if (run > longest) {
      longest = run;
      gap_end = b + 1;
    }
  }
  if (longest < 2 || longest > bins)
    return std::nullopt;
  Reach reach;
  world.agree_after([&] {
    if (!chart)
      return;
    const double turn = chart->units.turn(), width = turn / bins;
    reach = reach_of(mesh, chart->west + (gap_end - 0.5 * longest) * width, turn, threads);
  });
  world.reduce(std::span(&reach.low, 1), parallel::Reduction::least);
  world.reduce(std::span(&reach.high, 1), parallel::Reduction::greatest);
  return Longitudes{reach.low, reach.high};
}

} // namespace insitu::query
