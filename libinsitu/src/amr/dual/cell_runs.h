#pragma once

#include <algorithm>
#include <cstdint>

#include "mesh/adaptive.h"

namespace insitu::amr {

/// The piece of a flat cell.
inline std::int32_t piece_of(const mesh::AmrView& mesh, std::int64_t flat) {
  return std::int32_t(
             std::upper_bound(mesh.first_cell, mesh.first_cell + mesh.piece_count + 1, flat) -
             mesh.first_cell) -
         1;
}

/// Where a flat cell lies.
inline mesh::AmrCell cell_at(const mesh::AmrView& mesh, std::int64_t flat) {
  const std::int32_t p = piece_of(mesh, flat);
  return mesh.cell(mesh.pieces[p], flat - mesh.first_cell[p]);
}

/// Calls f(depth, index, count, first) for the flat cells [begin, end): runs of `count` cells along
/// i, from `index` and the flat cell `first` on.
template <class F>
void for_runs(const mesh::AmrView& mesh, std::int64_t begin, std::int64_t end, F&& f) {
  if (begin >= end)
    return;
  for (std::int32_t p = piece_of(mesh, begin); begin < end; ++p) {
    const mesh::AmrPieceView& piece = mesh.pieces[p];
    const std::int64_t first = mesh.first_cell[p], stop = std::min(end, mesh.first_cell[p + 1]);
    while (begin < stop) {
      mesh::AmrCell c = mesh.cell(piece, begin - first);
      if (!piece.is_patch) {
        f(c.depth, c.index, std::int64_t(1), begin++);
        continue;
      }
      while (begin < stop) {
        const std::int64_t count =
            std::min(stop - begin, piece.lower[0] + piece.size[0] - c.index[0]);
        f(c.depth, c.index, count, begin);
        begin += count;
        c.index[0] = piece.lower[0];
        if (++c.index[1] == piece.lower[1] + piece.size[1]) {
          c.index[1] = piece.lower[1];
          ++c.index[2];
        }
      }
    }
  }
}

} // namespace insitu::amr
