#include "cells/checks/odd_cells.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

#include "cells/checks/folds.h"
#include "cells/kernels/gather.h"

namespace insitu::cells {

namespace {

using mesh::Shape;

constexpr std::int64_t grain = 4096;

/// Some of a chunk's cells; the first few of each kind.
struct Some {
  std::int64_t count = 0;
  std::vector<std::int64_t> ids;
  void add(std::uint64_t bits, const std::int64_t* cells) {
    count += std::popcount(bits);
    for (; bits && std::int64_t(ids.size()) <= OddCells::most; bits &= bits - 1)
      ids.push_back(cells[std::countr_zero(bits)]);
  }
};

struct Chunk {
  Some bad, right, inverted;
};

void look(const mesh::MeshView& mesh, const CellGather& gather, std::int64_t begin,
          std::int64_t end, Chunk& chunk) {
  constexpr int first = int(Shape::tetrahedron), shapes = 5;
  CellBlock block;
  std::int64_t ids[shapes][CellBlock::size]; // waiting, by shape
  int waiting[shapes] = {};
  const auto look_at = [&](int shape) {
    block.count = std::exchange(waiting[shape], 0);
    gather.fill(ids[shape], block.count, 0, block);
    const CellKinds kinds = kinds_of(Shape(first + shape), block);
    const std::uint64_t bad = kinds.folded | kinds.flat;
    chunk.bad.add(bad, ids[shape]);
    chunk.inverted.add(kinds.inverted & ~bad, ids[shape]);
    chunk.right.add(block.all() & ~(kinds.inverted | bad), ids[shape]);
  };
  std::int32_t piece = mesh.piece_of(begin);
  for (std::int64_t cell = begin; cell < end; ++cell) {
    while (cell >= mesh.first_cell[piece + 1])
      ++piece;
    if (!mesh.pieces[piece].exists(cell - mesh.first_cell[piece]))
      continue;
    const int shape = int(gather.shape(cell)) - first;
    ids[shape][waiting[shape]++] = cell;
    if (waiting[shape] == CellBlock::size)
      look_at(shape);
  }
  for (int shape = 0; shape < shapes; ++shape)
    look_at(shape);
}

} // namespace

OddCells find_odd_cells(const mesh::MeshView& mesh, const core::Threads& threads) {
  OddCells odd;
  const std::int64_t count = mesh.cell_count();
  const CellGather gather(mesh, 1.0);
  std::vector<Chunk> chunks(std::size_t((count + grain - 1) / grain));
  std::atomic<bool> many{false}; // whatever the other chunks hold
  threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    if (many)
      return;
    Chunk& chunk = chunks[std::size_t(begin / grain)];
    look(mesh, gather, begin, end, chunk);
    if (chunk.bad.count > OddCells::most)
      many = true;
  });
  Chunk all;
  for (const Chunk& chunk : chunks) {
    all.bad.count += chunk.bad.count;
    all.right.count += chunk.right.count;
    all.inverted.count += chunk.inverted.count;
  }
  const bool mostly_inverted = all.inverted.count > all.right.count;
  const auto turned = [&](const Chunk& c) -> const Some& {
    return mostly_inverted ? c.right : c.inverted;
  };
  if (many || all.bad.count + turned(all).count > OddCells::most)
    return odd;
  odd.few = true;
  for (const Chunk& chunk : chunks) {
    odd.ids.insert(odd.ids.end(), chunk.bad.ids.begin(), chunk.bad.ids.end());
    odd.ids.insert(odd.ids.end(), turned(chunk).ids.begin(), turned(chunk).ids.end());
  }
  std::sort(odd.ids.begin(), odd.ids.end());
  return odd;
}

OddCells find_odd_cells(const mesh::MeshView& mesh, const insitu_validation& counts,
                        const core::Threads& threads) {
  const std::int64_t bad = counts.folded_cells + counts.zero_volume_cells;
  const std::int64_t right =
      counts.cells - counts.ghost_cells - counts.inverted_cells - bad; // at least
  OddCells odd;
  const std::int64_t turned = std::min(counts.inverted_cells, std::max<std::int64_t>(right, 0));
  if (bad + turned > OddCells::most)
    return odd;
  if (bad + turned == 0) {
    odd.few = true;
    return odd;
  }
  return find_odd_cells(mesh, threads);
}

} // namespace insitu::cells
