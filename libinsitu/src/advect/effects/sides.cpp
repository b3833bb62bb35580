#include "advect/effects/sides.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <vector>

#include "core/status.h"

namespace insitu::advect {

namespace {

/// f(result, box) with the box of each owning cell as it is now; the results, one a range of cells.
template <class Result, class F>
std::vector<Result> over_boxes(const mesh::MeshView& mesh, const core::Threads& threads,
                               const Result& none, F&& f) {
  constexpr std::int64_t grain = 4096;
  std::vector<Result> results(std::size_t((mesh.cell_count() + grain - 1) / grain), none);
  threads.parallel_for(mesh.cell_count(), grain, [&](std::int64_t begin, std::int64_t end) {
    mesh::CellVertices c;
    for (std::int64_t cell = begin; cell < end; ++cell) {
      const std::int32_t piece = mesh.piece_of(cell);
      if (!mesh.pieces[piece].exists(cell - mesh.first_cell[piece]))
        continue;
      mesh::gather(mesh, cell, c);
      f(results[std::size_t(begin / grain)], box_of(c));
    }
  });
  return results;
}

void join(Box& box, const Box& other) {
  box.extend(other);
}

/// The box of all of them.
Box whole_box(const mesh::MeshView& mesh, const core::Threads& threads) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Box all{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  for (const Box& box : over_boxes(mesh, threads, all, join))
    join(all, box);
  return all;
}

/// Where a geodetic mesh, among images, begins and ends in longitude: on either side of the widest
/// gap. False if there is none of a fifth of a degree or more.
bool longitudes_of(const mesh::MeshView& mesh, const query::ChartImage& chart,
                   const core::Threads& threads, Box& box) {
  constexpr int bins = 3600;
  const double turn = chart.units.turn(), width = turn / bins;
  const auto bin = [&](double x) { return int(std::floor((x - chart.west) / width)); };
  std::bitset<bins> taken;
  for (const std::bitset<bins>&part :
       over_boxes(mesh, threads, taken, [&](std::bitset<bins>&t, const Box&cell) {
         for (int b = bin(cell.low.x); b <= bin(cell.high.x); ++b)
           t.set(std::size_t((b % bins + bins) % bins));
       }))
    taken |= part;
  int longest = 0, gap_end = 0;
  for (int b = 0, run = 0; b < 2 * bins; ++b) {
    run = taken[std::size_t(b % bins)] ? 0 : run + 1;
    if (run > longest) {
      longest = run;
      gap_end = b + 1;
    }
  }
  if (longest < 2 || longest > bins)
    return false;
  const double gap = chart.west + (gap_end - 0.5 * longest) * width;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  struct Reach {
    double low = infinity, high = -infinity;
  };
  Reach all;
  for (const Reach& part : over_boxes(mesh, threads, Reach(), [&](Reach&r, const Box&cell) {
         const double turns = turn * std::floor((cell.low.x - gap) / turn);
         r.low = std::min(r.low, cell.low.x - turns);
         r.high = std::max(r.high, cell.high.x - turns);
       })) {
    all.low = std::min(all.low, part.low);
    all.high = std::max(all.high, part.high);
  }
  box.low.x = all.low;
  box.high.x = all.high;
  return true;
}

} // namespace

Sides sides_of(const query::Sampler& sampler, const BoundaryEffect& boundary,
               const core::Threads& threads) {
  if (!boundary.any_periodic())
    return {};
  const query::ChartImage* chart = sampler.chart();
  if (!chart)
    return Sides(whole_box(sampler.mesh(), threads), boundary.periodic);
  if (boundary.periodic[1] || boundary.periodic[2])
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "tracer: on a mesh in longitude and latitude periodic sides are those along "
                      "x, its western and eastern ones: no others are as long as each other");
  const mesh::MeshView& mesh = sampler.among_images().mesh();
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    if (geo::Pole(mesh.pieces[p].pole) != geo::Pole::none)
      throw core::Error(INSITU_ERROR_UNSUPPORTED,
                        "tracer: periodic sides are not for meshes with cells at a pole");
  Box box;
  return longitudes_of(mesh, *chart, threads, box)
             ? Sides(box, boundary.periodic, chart->units.turn())
             : Sides();
}

} // namespace insitu::advect
