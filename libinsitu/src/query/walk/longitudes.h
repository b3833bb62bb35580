#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/parallel.h"
#include "mesh/box.h"
#include "mesh/view.h"
#include "parallel/world.h"
#include "query/chart_image.h"

namespace insitu::query {

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
      f(results[std::size_t(begin / grain)], mesh::box_of(c));
    }
  });
  return results;
}

/// Where meshes in longitude and latitude begin and end in longitude.
struct Longitudes {
  double low, high; ///< less than a turn apart
};
/// Of the meshes of all processes, among images: on either side of the widest gap. None if there is
/// none of a fifth of a degree or more. chart: null where a process has no cells. Collective;
/// throws parallel::AgreedError.
std::optional<Longitudes> longitudes_of(const mesh::MeshView& mesh, const ChartImage* chart,
                                        const core::Threads& threads, parallel::World& world);

} // namespace insitu::query
