#include "render/vertex_cells.h"

#include <algorithm>
#include <atomic>

namespace insitu::render {

VertexCells::VertexCells(const mesh::MeshView& mesh, std::int32_t p, const core::Threads& threads,
                         core::Memory& memory)
    : end_(memory, INSITU_MEMORY_FRAME), cells_(memory, INSITU_MEMORY_FRAME) {
  constexpr std::int64_t grain = 4096;
  const mesh::PieceView& piece = mesh.pieces[p];
  const std::int64_t cell_count = mesh.first_cell[p + 1] - mesh.first_cell[p];
  const std::int64_t vertex_count = mesh.first_vertex[p + 1] - mesh.first_vertex[p];
  end_.resize_discard(std::size_t(vertex_count) + 1);
  std::fill(end_.begin(), end_.end(), 0);

  const auto for_each_corner = [&](auto&& visit) {
    threads.parallel_for(cell_count, grain, [&](std::int64_t begin, std::int64_t stop) {
      std::int64_t ids[8];
      for (std::int64_t cell = begin; cell < stop; ++cell) {
        if (!piece.owns(cell))
          continue;
        const int n = piece.vertex_ids(cell, ids);
        for (int v = 0; v < n; ++v)
          visit(cell, ids[v]);
      }
    });
  };
  for_each_corner([&](std::int64_t, std::int64_t vertex) {
    std::atomic_ref(end_[std::size_t(vertex) + 1]).fetch_add(1, std::memory_order_relaxed);
  });
  for (std::int64_t v = 0; v < vertex_count; ++v)
    end_[std::size_t(v) + 1] += end_[std::size_t(v)];
  cells_.resize_discard(std::size_t(end_[std::size_t(vertex_count)]));
  // Filling moves end_[v] from the list's begin to its end.
  for_each_corner([&](std::int64_t cell, std::int64_t vertex) {
    const std::int64_t at =
        std::atomic_ref(end_[std::size_t(vertex)]).fetch_add(1, std::memory_order_relaxed);
    cells_[std::size_t(at)] = std::uint32_t(cell);
  });
  threads.parallel_for(vertex_count, grain, [&](std::int64_t begin, std::int64_t stop) {
    for (std::int64_t v = begin; v < stop; ++v)
      std::sort(cells_.data() + (v == 0 ? 0 : end_[std::size_t(v) - 1]),
                cells_.data() + end_[std::size_t(v)]);
  });
}

} // namespace insitu::render
