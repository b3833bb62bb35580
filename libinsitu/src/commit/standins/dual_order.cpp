#include "commit/standins/dual_order.h"

#include <algorithm>
#include <limits>
#include <ranges>

#include "core/status.h"

namespace insitu::commit {

namespace {

using mesh::Gridlet;

// From the highest bits on: the kind, the depth, the brick, the corner in it, the cell there.
constexpr int depth_bits = 5, corner_bits = 10, cell_bits = 5;
constexpr int brick_bits = 41;
constexpr std::int64_t most_bricks = std::int64_t(1) << brick_bits;
constexpr std::int64_t corners = 9; ///< of a brick, along an axis

/// The first cells of runs in which all bricks are: gridlets, and other cells.
template <class F>
void for_places(const amr::DualMesh& dual, F&& f) {
  const mesh::MeshView& view = dual.view();
  for (std::int64_t g = 0; g < view.first_cell[1]; g += Gridlet::most_cells)
    f(dual.place(g));
  for (std::int64_t cell = view.first_cell[1]; cell < view.first_cell[2]; ++cell)
    f(dual.place(cell));
}

} // namespace

void DualOrder::build(const amr::DualMesh& dual, parallel::World& world) {
  constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  std::int64_t least[depths][3], below[depths][3]; // of -brick, too
  world.agree_after([&] {
    std::fill_n(&least[0][0], 3 * depths, none);
    std::fill_n(&below[0][0], 3 * depths, none);
    for_places(dual, [&](const amr::CellPlace& place) {
      for (int a = 0; a < 3; ++a) {
        least[place.depth][a] = std::min<std::int64_t>(least[place.depth][a], place.brick(a));
        below[place.depth][a] = std::min<std::int64_t>(below[place.depth][a], -place.brick(a));
      }
    });
  });
  world.reduce(std::span(&least[0][0], 3 * depths), parallel::Reduction::least);
  world.reduce(std::span(&below[0][0], 3 * depths), parallel::Reduction::least);
  world.agree_after([&] {
    has_gridlets_ = dual.has_gridlets();
    for (int d = 0; d < depths; ++d) {
      double bricks = 1.0;
      for (int a = 0; a < 3; ++a) {
        first_[d][a] = least[d][a] == none ? 0 : least[d][a];
        count_[d][a] = least[d][a] == none ? 0 : 1 - below[d][a] - least[d][a];
        bricks *= double(count_[d][a]);
      }
      if (bricks > double(most_bricks))
        throw core::Error(
            INSITU_ERROR_UNSUPPORTED,
            "an adaptive mesh over processes that is " + std::to_string(8 * count_[d][0]) + " x " +
                std::to_string(8 * count_[d][1]) + " x " + std::to_string(8 * count_[d][2]) +
                " cells of a level wide: its cells cannot be numbered");
    }
  });
}

std::int64_t DualOrder::number(const amr::DualMesh& dual, std::int64_t flat) const {
  const amr::CellPlace place = dual.place(flat);
  const std::int64_t *const first = first_[place.depth], *const count = count_[place.depth];
  std::int64_t brick = 0, corner = 0;
  for (int a = 2; a >= 0; --a) {
    brick = brick * count[a] + place.brick(a) - first[a];
    corner = corner * corners + place.corner[a] - 8 * place.brick(a);
  }
  const std::int64_t kind = !place.is_cube ? 1 : has_gridlets_ ? 0 : 2;
  return (((kind << depth_bits | place.depth) * most_bricks + brick) << corner_bits | corner)
             << cell_bits |
         place.number;
}

std::int64_t DualOrder::find(const amr::DualMesh& dual, std::int64_t number) const {
  const mesh::MeshView& view = dual.view();
  const bool in_gridlet = number >> (depth_bits + brick_bits + corner_bits + cell_bits) == 0;
  const std::int64_t cell = in_gridlet ? find_in_gridlets(dual, number) : find_beside(dual, number);
  if (cell < 0 || this->number(dual, cell) != number)
    return -1;
  const std::int32_t piece = view.piece_of(cell);
  return view.pieces[piece].exists(cell - view.first_cell[piece]) ? cell : -1;
}

/// The cell of a gridlet that has the place of this number, or some other one; or -1. The first
/// cells of gridlets ascend; but of cells that do not exist some have places in the next brick.
std::int64_t DualOrder::find_in_gridlets(const amr::DualMesh& dual, std::int64_t number) const {
  const auto first_of = [](std::int64_t gridlet) { return gridlet * Gridlet::most_cells; };
  const auto all =
      std::views::iota(std::int64_t(0), dual.view().first_cell[1] / Gridlet::most_cells);
  const auto after = std::ranges::upper_bound(
      all, number, {}, [&](std::int64_t gridlet) { return this->number(dual, first_of(gridlet)); });
  if (after == all.begin())
    return -1;
  std::int64_t cell = first_of(*std::ranges::prev(after));
  const amr::CellPlace first = dual.place(cell);
  std::int64_t corner = number >> cell_bits & ((1 << corner_bits) - 1);
  for (int a = 0; a < 3; ++a, corner /= corners) {
    const std::int64_t along = corner % corners - (first.corner[a] - 8 * first.brick(a));
    if (along < 0 || along >= Gridlet::side)
      return -1;
    cell += along << (3 * a);
  }
  return cell;
}

/// The cell of piece 1 of this number, or some other one; or -1.
std::int64_t DualOrder::find_beside(const amr::DualMesh& dual, std::int64_t number) const {
  const std::int64_t* const first = dual.view().first_cell;
  const auto cells = std::views::iota(first[1], first[2]);
  const auto at = std::ranges::lower_bound(
      cells, number, {}, [&](std::int64_t cell) { return this->number(dual, cell); });
  return at == cells.end() ? -1 : *at;
}

} // namespace insitu::commit
