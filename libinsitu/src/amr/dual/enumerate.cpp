#include "amr/dual/enumerate.h"

#include <algorithm>
#include <bit>

namespace insitu::amr {

namespace {

using mesh::Gridlet;

/// The gridlet of a brick: its cubes are those whose lowest leaf lies in the brick.
void add_gridlet(const Neighborhood& around, std::int64_t real, DualPart& part) {
  std::uint64_t layers[8];
  std::uint64_t all = 0;
  int lower[3] = {8, 8, 8}, upper[3] = {0, 0, 0};
  for (int k = 0; k < 8; ++k) {
    layers[k] = 0;
    for (int j = 0; j < 8; ++j)
      layers[k] |= std::uint64_t(around.cubes(j + 1, k + 1) >> 1 & 0xff) << (8 * j);
    if (layers[k] == 0)
      continue;
    lower[2] = std::min(lower[2], k);
    upper[2] = k + 1;
    all |= layers[k];
    part.cubes += std::popcount(layers[k]);
  }
  if (all == 0)
    return;
  lower[1] = std::countr_zero(all) / 8;
  upper[1] = 8 - std::countl_zero(all) / 8;
  std::uint64_t row = all | all >> 32;
  row |= row >> 16;
  row = (row | row >> 8) & 0xff;
  lower[0] = std::countr_zero(row);
  upper[0] = 64 - std::countl_zero(row);

  Gridlet g;
  g.depth = std::uint8_t(around.depth());
  g.first = std::uint32_t(part.leaves.size());
  for (int a = 0; a < 3; ++a) {
    g.lower[a] = std::int32_t(around.lower(a) + 1 + lower[a]);
    g.size[a] = std::uint8_t(upper[a] - lower[a]);
  }
  part.gridlets.push_back(g);
  part.empty += g.size[0] * g.size[1] * g.size[2];
  for (int k = 0; k < 8; ++k)
    part.full.push_back(k < g.size[2] ? layers[k + lower[2]] >> (8 * lower[1] + lower[0]) : 0);
  for (int k = lower[2]; k <= upper[2]; ++k)
    for (int j = lower[1]; j <= upper[1]; ++j)
      for (int i = lower[0]; i <= upper[0]; ++i) {
        const std::uint32_t id = around.entry(i + 1, j + 1, k + 1);
        part.leaves.push_back(id < real ? id : mesh::GridletsView::no_leaf);
      }
}

bool touches_virtual(const Corner& corner, std::int64_t real) {
  for (int o = 0; o < 8; ++o)
    if ((corner.inside >> o & 1) && corner.id[o] >= real)
      return true;
  return false;
}

CornerCell corner_cell(const Corner& corner, std::uint32_t cell) {
  return {
      {std::int32_t(corner.index[0]), std::int32_t(corner.index[1]), std::int32_t(corner.index[2])},
      std::uint8_t(corner.depth),
      CornerKind::of(corner),
      cell};
}

void add_cell(const Corner& corner, const mesh::Lattice& lattice, std::int64_t first_virtual,
              bool is_wanted, DualCells& cells, DualPart& part) {
  DualCell cell;
  bool folded = false;
  if (cells.make(corner, cell)) {
    folded = (corner.most_up > 1 || touches_virtual(corner, first_virtual)) && cells.folds();
    if (is_wanted) {
      part.at_corners.push_back(corner_cell(corner, std::uint32_t(part.cells.size())));
      part.cells.push_back(cell);
    }
  } else {
    folded = split_reentrant(corner, lattice, part.cells, part.means);
  }
  part.folded += folded;
  if (corner.most_up > 1)
    part.steep.emplace_back(corner, folded);
}

/// Of the cells from `first` on, which are those at a corner of a brick.
void add_places(const Corner& corner, const Neighborhood& around, std::size_t first,
                DualPart& part) {
  for (std::size_t n = first; n < part.cells.size(); ++n) {
    CellPlace place{{}, std::uint8_t(corner.depth), 0, std::uint8_t(n - first), 0};
    for (int a = 0; a < 3; ++a) {
      place.corner[a] = std::int32_t(corner.index[a]);
      place.at_end = std::uint8_t(place.at_end |
                                  (corner.index[a] - around.lower(a) - 1 == BrickStore::side) << a);
    }
    part.places.push_back(place);
  }
}

} // namespace

SteepCorner::SteepCorner(const Corner& corner, bool folds)
    : index{corner.index[0], corner.index[1], corner.index[2]}, depth(std::int8_t(corner.depth)),
      folded(folds) {
  for (int o = 0; o < 8; ++o)
    if ((corner.inside >> o & 1) && corner.up[o] > 1)
      octants |= std::uint8_t(1 << o);
}

void enumerate(const BrickStore& store, const mesh::Lattice& lattice,
               std::span<const std::uint32_t> bricks, const Real& real, bool only_unfolded,
               DualPart& part) {
  Neighborhood around;
  Corner corner;
  DualCells& cells = DualCells::of_thread();
  for (const std::uint32_t b : bricks) {
    if (!around.load(store, b, real.end, real.near))
      continue;
    const auto is_wanted = [&] { return !only_unfolded || part.folded == 0; };
    if (is_wanted()) // before corners: they note coarser leaves in the entries
      add_gridlet(around, real.end, part);
    const auto counts = [&](int k) { // of a flat mesh the corners below its cells
      return lattice.is_flat == 0 || around.lower(2) + k + 1 == 0;
    };
    for (int k = 0; k < 9; ++k)
      for (int j = 0; j < 9 && counts(k); ++j)
        for (unsigned row = around.mixed(j, k); row != 0; row &= row - 1) {
          if (!around.take(store, std::countr_zero(row), j, k, corner))
            continue;
          if (real.counts(corner)) {
            const std::size_t first = part.cells.size();
            add_cell(corner, lattice, real.end, is_wanted(), cells, part);
            if (real.with_places)
              add_places(corner, around, first, part);
          } else if (DualCell cell; real.knows(corner) && cells.make(corner, cell)) {
            part.at_corners.push_back(corner_cell(corner, CornerCell::not_here));
          }
        }
  }
  part.empty -= part.cubes;
  if (only_unfolded && part.folded > 0) {
    DualPart rest;
    rest.steep = std::move(part.steep);
    rest.folded = part.folded;
    part = std::move(rest);
  }
}

} // namespace insitu::amr
