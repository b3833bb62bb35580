#include "advect/across/own_boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "query/directory.h"

namespace insitu::advect {

using math::Vec3d;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr mesh::Box nothing{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

/// Coordinates between the steps may be beyond both by rounding.
void widen(mesh::Box& box) {
  for (int a = 0; a < 3; ++a) {
    const double rounding = 8.0 * std::numeric_limits<double>::epsilon() *
                            std::max(std::abs(box.low[a]), std::abs(box.high[a]));
    box.low[a] -= rounding;
    box.high[a] += rounding;
  }
}

} // namespace

std::vector<mesh::Box> own_boxes(const mesh::MeshView& mesh, const Homes& homes,
                                 const core::Threads& threads) {
  constexpr auto most = std::int64_t(query::Directory::most_boxes);
  const std::int64_t cells = mesh.cell_count();
  const std::int64_t grain = std::max<std::int64_t>((cells + most - 1) / most, 1);
  std::vector<mesh::Box> boxes(std::size_t((cells + grain - 1) / grain), nothing);
  threads.parallel_for(cells, grain, [&](std::int64_t begin, std::int64_t end) {
    mesh::Box& box = boxes[std::size_t(begin / grain)];
    mesh::CellVertices c;
    for (std::int64_t cell = begin; cell < end; ++cell) {
      const std::int32_t p = mesh.piece_of(cell);
      if (!mesh.pieces[p].exists(cell - mesh.first_cell[p]) || !homes.is_own(cell))
        continue;
      mesh::gather(mesh, cell, c);
      box.extend(mesh::box_of(c));
      if (mesh.earlier_points) {
        mesh::gather(mesh, cell, c, 0.0);
        box.extend(mesh::box_of(c));
      }
    }
  });
  std::erase_if(boxes, [](const mesh::Box& box) { return !(box.low.x <= box.high.x); });
  std::ranges::for_each(boxes, widen);
  return boxes;
}

} // namespace insitu::advect
