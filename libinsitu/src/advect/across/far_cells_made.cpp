// FarCells of one interval, as all processes together make them.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "advect/across/rounds.h"

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

/// Some boxes that hold all cells that this process owns, between the earlier and the current step:
/// at most query::Directory::most_boxes of them, each of cells whose numbers follow each other.
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

} // namespace

void make_far_cells(const Across& across, const query::Sampler& here, const core::Threads& threads,
                    core::FunctionRef<std::vector<FarCells::InTime>()> fields_of,
                    std::optional<FarCells>& cells) {
  parallel::World& world = across.world;
  std::vector<mesh::Box> own;
  std::vector<FarCells::InTime> fields;
  std::vector<std::int64_t> facts;
  world.agree_after([&] {
    own = own_boxes(here.mesh(), across.homes, threads);
    fields = fields_of();
    facts = FarCells::facts(here, fields);
  });
  query::Directory directory;
  directory.gather(own, world);
  world.reduce(std::span(facts), parallel::Reduction::greatest);
  world.agree_after([&] {
    cells.emplace(here, across.homes, std::move(directory), world.rank(), fields, facts);
  });
}

} // namespace insitu::advect
