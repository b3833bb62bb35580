#include "advect/sides.h"

#include <limits>
#include <vector>

namespace insitu::advect {

namespace {

/// The box of the owning cells' vertices as they are now.
Box box_of(const mesh::MeshView& mesh, const core::Threads& threads) {
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

} // namespace

Sides sides_of(const mesh::MeshView& mesh, const BoundaryEffect& boundary,
               const core::Threads& threads) {
  return boundary.any_periodic() ? Sides(box_of(mesh, threads), boundary.periodic) : Sides();
}

} // namespace insitu::advect
