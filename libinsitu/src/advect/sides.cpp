#include "advect/sides.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <vector>

#include "core/status.h"

namespace insitu::advect {

namespace {

/// The box of the owning cells' vertices as they are now.
Box whole_box(const mesh::MeshView& mesh, const core::Threads& threads) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Box none{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  constexpr std::int64_t grain = 4096;
  std::vector<Box> boxes(std::size_t((mesh.cell_count() + grain - 1) / grain), none);
  threads.parallel_for(mesh.cell_count(), grain, [&](std::int64_t begin, std::int64_t end) {
    Box& box = boxes[std::size_t(begin / grain)];
    mesh::CellVertices c;
    for (std::int64_t cell = begin; cell < end; ++cell) {
      const std::int32_t piece = mesh.piece_of(cell);
      if (!mesh.pieces[piece].owns(cell - mesh.first_cell[piece]))
        continue;
      mesh::gather(mesh, cell, c);
      for (int v = 0; v < c.count; ++v)
        for (int a = 0; a < 3; ++a) {
          box.low[a] = std::min(box.low[a], c.x[v][a]);
          box.high[a] = std::max(box.high[a], c.x[v][a]);
        }
    }
  });
  Box all = none;
  for (const Box& box : boxes)
    for (int a = 0; a < 3; ++a) {
      all.low[a] = std::min(all.low[a], box.low[a]);
      all.high[a] = std::max(all.high[a], box.high[a]);
    }
  return all;
}

/// f(result, low, high) with the longitudes of each owning cell; the results, one a range of cells.
template <class Result, class F>
std::vector<Result> over_longitudes(const mesh::MeshView& mesh, const core::Threads& threads,
                                    const Result& none, F&& f) {
  constexpr std::int64_t grain = 4096;
  std::vector<Result> results(std::size_t((mesh.cell_count() + grain - 1) / grain), none);
  threads.parallel_for(mesh.cell_count(), grain, [&](std::int64_t begin, std::int64_t end) {
    mesh::CellVertices c;
    for (std::int64_t cell = begin; cell < end; ++cell) {
      const std::int32_t piece = mesh.piece_of(cell);
      if (!mesh.pieces[piece].owns(cell - mesh.first_cell[piece]))
        continue;
      mesh::gather(mesh, cell, c);
      const Box box = box_of(c);
      f(results[std::size_t(begin / grain)], box.low.x, box.high.x);
    }
  });
  return results;
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
       over_longitudes(mesh, threads, taken, [&](std::bitset<bins>&t, double low, double high) {
         for (int b = bin(low); b <= bin(high); ++b)
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
  for (const Reach& part :
       over_longitudes(mesh, threads, Reach(), [&](Reach&r, double low, double high) {
         const double turns = turn * std::floor((low - gap) / turn);
         r.low = std::min(r.low, low - turns);
         r.high = std::max(r.high, high - turns);
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
