#include "render/structures/scalar_field.h"

#include <algorithm>
#include <cmath>
#include <mutex>

namespace insitu::render {

ScalarRange scalar_range(const mesh::MeshView& mesh, const ScalarField& scalar,
                         const core::Threads& threads) {
  ScalarRange range;
  std::mutex mutex; // minima and maxima are the same in any order
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    const std::int64_t cells = mesh.first_cell[p + 1] - mesh.first_cell[p];
    threads.parallel_for(cells, 16384, [&](std::int64_t begin, std::int64_t end) {
      ScalarRange part;
      const auto add = [&](double v) {
        if (!std::isfinite(v))
          return;
        part.low = v < part.low ? v : part.low;
        part.high = v > part.high ? v : part.high;
      };
      std::int64_t ids[8];
      for (std::int64_t cell = begin; cell < end; ++cell) {
        if (!piece.owns(cell))
          continue;
        if (scalar.field.association == INSITU_CELL) {
          add(scalar.load(p, cell));
          continue;
        }
        const int n = piece.vertex_ids(cell, ids);
        for (int v = 0; v < n; ++v)
          add(scalar.load(p, ids[v]));
      }
      const std::lock_guard lock(mutex);
      range.low = std::min(range.low, part.low);
      range.high = std::max(range.high, part.high);
    });
  }
  return range;
}

} // namespace insitu::render
