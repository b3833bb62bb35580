#include "render/vertex_cells.h"

#include <algorithm>
#include <atomic>

#include "mesh/ghosts.h"

namespace insitu::render {

namespace {

constexpr std::int64_t grain = 4096;

/// Whether a cell counts at its vertices.
bool counts(const mesh::PieceView& piece, std::int64_t cell) {
  return piece.owns(cell) || (mesh::is_duplicate(piece, cell) && mesh::has_sound_ids(piece, cell));
}

/// visit(flat cell, flat vertex) of the counting cells' corners, in parallel.
template <class Visit>
void for_each_corner(const mesh::MeshView& mesh, const core::Threads& threads, Visit&& visit) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    const std::int64_t first_cell = mesh.first_cell[p], first_vertex = mesh.first_vertex[p];
    threads.parallel_for(mesh.first_cell[p + 1] - first_cell, grain,
                         [&](std::int64_t begin, std::int64_t stop) {
                           std::int64_t ids[8];
                           for (std::int64_t cell = begin; cell < stop; ++cell) {
                             if (!counts(piece, cell))
                               continue;
                             const int n = piece.vertex_ids(cell, ids);
                             for (int v = 0; v < n; ++v)
                               visit(first_cell + cell, first_vertex + ids[v]);
                           }
                         });
  }
}

} // namespace

VertexCells::VertexCells(const mesh::MeshView& mesh, const core::Threads& threads,
                         core::Memory& memory)
    : end_(memory, INSITU_MEMORY_FRAME), cells_(memory, INSITU_MEMORY_FRAME) {
  const std::int64_t vertex_count = mesh.vertex_count();
  end_.resize_discard(std::size_t(vertex_count) + 1);
  std::fill(end_.begin(), end_.end(), 0);
  for_each_corner(mesh, threads, [&](std::int64_t, std::int64_t vertex) {
    std::atomic_ref(end_[std::size_t(vertex) + 1]).fetch_add(1, std::memory_order_relaxed);
  });
  for (std::int64_t v = 0; v < vertex_count; ++v)
    end_[std::size_t(v) + 1] += end_[std::size_t(v)];
  cells_.resize_discard(std::size_t(end_[std::size_t(vertex_count)]));
  // Filling moves end_[v] from the list's begin to its end.
  for_each_corner(mesh, threads, [&](std::int64_t cell, std::int64_t vertex) {
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

std::int64_t VertexCells::bytes_for(const mesh::MeshView& mesh, const core::Threads& threads) {
  std::atomic<std::int64_t> corners{0};
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    threads.parallel_for(mesh.first_cell[p + 1] - mesh.first_cell[p], grain,
                         [&](std::int64_t begin, std::int64_t stop) {
                           std::int64_t sum = 0;
                           for (std::int64_t cell = begin; cell < stop; ++cell)
                             sum += counts(piece, cell) ? mesh::vertex_count(piece.shape(cell)) : 0;
                           corners += sum;
                         });
  }
  return (mesh.vertex_count() + 1) * std::int64_t(sizeof(std::int64_t)) +
         corners * std::int64_t(sizeof(std::uint32_t));
}

} // namespace insitu::render
