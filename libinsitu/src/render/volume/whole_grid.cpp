#include "render/volume/whole_grid.h"

#include <cmath>
#include <mutex>

#include "render/volume/cell_columns.h"

namespace insitu::render {

namespace {

constexpr double units = 0x1p30; ///< in the mesh's width

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
      for (int a = 0; a < 3; ++a)
        if (size[a] > 0)
          sums[std::size_t(a)] += std::llround(units * (width[a] / size[a]));
    }
    const std::lock_guard lock(mutex);
    for (std::size_t a = 0; a < 3; ++a)
      all[a] += sums[a];
  });
  return all;
}

MacrocellGrid whole_grid(const mesh::MeshFacts& whole, const CellWidths& widths,
                         const MacrocellFineness& fineness) {
  double across[3];
  for (std::size_t a = 0; a < 3; ++a)
    across[a] =
        widths[a] > 0 ? std::max(1.0, units * double(whole.cells) / double(widths[a])) : 1.0;
  return MacrocellGrid::over(whole.cells > 0 ? whole.bounds : mesh::Box{}, across,
                             double(whole.cells), fineness);
}

} // namespace insitu::render
