#include "render/volume/whole_grid.h"

#include <cmath>
#include <mutex>

#include "render/volume/cell_columns.h"

namespace insitu::render {

namespace {

constexpr double units = 0x1p30; ///< in the mesh's width, and so on

/// How many macrocells a cell meets, on average: that is the mean of the product of (1 + the layers
/// that a cell is wide) over the axes.
double coverage_of(const CellWidths& widths, const MacrocellGrid& grid) {
  double met = 0;
  for (std::size_t axes = 0; axes < widths.size(); ++axes) {
    double layers = double(widths[axes]);
    for (std::size_t a = 0; a < 3; ++a)
      layers *= axes >> a & 1 ? grid.counts[a] : 1;
    met += layers;
  }
  return met / double(widths[0]);
}

} // namespace

CellWidths cell_widths(const query::Sampler& sampler, const mesh::Box& whole,
                       const core::Threads& threads) {
  const math::Vec3d size = whole.size();
  CellWidths all{};
  std::mutex mutex;
  const auto none = [](std::int64_t) { return false; };
  OwningCells(sampler).for_each(threads, none, [&](const CellColumns& cells) {
    CellWidths sums{};
    for (int k = 0; k < int(cells.cells().size()); ++k) {
      if (!sampler.mesh().is_own(cells.cells()[std::size_t(k)]))
        continue; // another process counts it
      const math::Vec3d width = cells.box(k).size();
      double share[3];
      for (int a = 0; a < 3; ++a)
        share[a] = size[a] > 0 ? width[a] / size[a] : 0.0;
      for (std::size_t axes = 0; axes < sums.size(); ++axes)
        sums[axes] += std::llround(units * (axes & 1 ? share[0] : 1.0) *
                                   (axes & 2 ? share[1] : 1.0) * (axes & 4 ? share[2] : 1.0));
    }
    const std::lock_guard lock(mutex);
    for (std::size_t axes = 0; axes < sums.size(); ++axes)
      all[axes] += sums[axes];
  });
  return all;
}

MacrocellGrid whole_grid(const mesh::MeshFacts& whole, const CellWidths& widths,
                         const MacrocellFineness& fineness) {
  if (whole.cells <= 0 || widths[0] <= 0)
    return MacrocellGrid::over({}, {1, 1, 1}, 0, fineness);
  double across[3];
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t of_axis = widths[std::size_t(1) << a];
    across[a] = of_axis > 0 ? std::max(1.0, double(widths[0]) / double(of_axis)) : 1.0;
  }
  MacrocellGrid grid = MacrocellGrid::over(whole.bounds, across, double(whole.cells), fineness);
  grid.coarsen([&](const MacrocellGrid& of) { return coverage_of(widths, of); });
  return grid;
}

} // namespace insitu::render
