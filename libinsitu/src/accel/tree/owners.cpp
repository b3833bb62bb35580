#include "accel/tree/owners.h"

#include <cmath>
#include <string>

#include "core/status.h"

namespace insitu::accel {

void RefusedCells::check(const mesh::MeshView& mesh) const {
  const std::int64_t flat = first_;
  if (flat == std::numeric_limits<std::int64_t>::max())
    return;
  const std::int32_t piece = mesh.piece_of(flat);
  throw core::Error(INSITU_ERROR_MESH, "piece " + std::to_string(piece) + ", cell " +
                                           std::to_string(flat - mesh.first_cell[piece]) +
                                           ": a vertex coordinate is not finite or beyond 1e37");
}

/// The middle of one vertex of some cells of each chunk is middle enough.
Owners::Owners(const mesh::MeshView& mesh, const core::Threads& threads) : mesh_(&mesh) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    selects_ |= mesh.pieces[p].may_not_exist();
  const std::int64_t cells = mesh.cell_count();
  const auto chunks = std::size_t((cells + grain - 1) / grain);
  start_.assign(chunks + 1, 0);
  std::vector<math::Vec3d> low(chunks), high(chunks);
  threads.parallel_for(cells, grain, [&](std::int64_t begin, std::int64_t end) {
    constexpr std::int64_t every = 128;
    std::int64_t n = 0;
    math::Vec3d lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
    for (std::int64_t flat = begin; flat < end; flat = selects_ ? next(flat) : flat + every) {
      if (selects_ && (!owns(flat) || n++ % every != 0))
        continue;
      const std::int32_t p = mesh.piece_of(flat);
      std::int64_t ids[8];
      mesh.pieces[p].vertex_ids(flat - mesh.first_cell[p], ids);
      const math::Vec3d x = mesh.pieces[p].point(ids[0]);
      for (int a = 0; a < 3; ++a) {
        if (!(std::fabs(x[a]) <= 1e37)) // refused later; it must not move the frame off the others
          continue;
        lo[a] = x[a] < lo[a] ? x[a] : lo[a];
        hi[a] = x[a] > hi[a] ? x[a] : hi[a];
      }
    }
    const auto chunk = std::size_t(begin / grain);
    start_[chunk + 1] = selects_ ? n : end - begin;
    low[chunk] = lo;
    high[chunk] = hi;
  });
  math::Vec3d lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
  for (std::size_t c = 0; c < chunks; ++c) {
    start_[c + 1] += start_[c];
    for (int a = 0; a < 3; ++a) {
      lo[a] = low[c][a] < lo[a] ? low[c][a] : lo[a];
      hi[a] = high[c][a] > hi[a] ? high[c][a] : hi[a];
    }
  }
  for (int a = 0; a < 3; ++a)
    origin_[a] = lo[a] > hi[a] ? 0.0 : 0.5 * lo[a] + 0.5 * hi[a];
}

} // namespace insitu::accel
