#include "render/structures/vertex_cells.h"

#include <algorithm>
#include <atomic>
#include <vector>

#include "mesh/ghosts.h"

namespace insitu::render {

namespace {

constexpr std::int64_t grain = 4096;

/// Whether a cell counts at its vertices. Where a halo is, a solver's duplicates would count twice.
bool counts(const mesh::MeshView& mesh, const mesh::PieceView& piece, std::int64_t cell) {
  return piece.exists(cell) || (mesh.halo_piece_count == 0 && mesh::is_duplicate(piece, cell) &&
                                mesh::has_sound_ids(piece, cell));
}

/// Whether two cells have the same vertices, by coordinates, in any order.
bool are_copies(const mesh::MeshView& mesh, std::uint32_t a, std::uint32_t b) {
  mesh::CellVertices of_a, of_b;
  mesh::gather(mesh, a, of_a);
  mesh::gather(mesh, b, of_b);
  return of_a.piece != of_b.piece && of_a.count == of_b.count &&
         std::is_permutation(of_a.x, of_a.x + of_a.count, of_b.x);
}

/// Leaves out duplicate ghosts of cells that count by themselves, and of other duplicates before.
void leave_out_copies(const mesh::MeshView& mesh, std::vector<std::uint32_t>& cells) {
  const auto owns = [&](std::uint32_t flat) {
    const std::int32_t p = mesh.piece_of(flat);
    return mesh.pieces[p].exists(flat - mesh.first_cell[p]);
  };
  std::vector<std::uint32_t> kept;
  for (const std::uint32_t cell : cells)
    if (owns(cell) || std::none_of(cells.begin(), cells.end(), [&](std::uint32_t other) {
          return (other < cell || owns(other)) && are_copies(mesh, cell, other);
        }))
      kept.push_back(cell);
  cells = std::move(kept);
}

/// visit(flat cell, flat vertex) of the counting cells' corners, in parallel.
template <class Visit>
void for_each_corner(const mesh::MeshView& mesh, const ChartCopies* copies,
                     const core::Threads& threads, Visit&& visit) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    const std::int64_t first_cell = mesh.first_cell[p], first_vertex = mesh.first_vertex[p];
    threads.parallel_for(mesh.first_cell[p + 1] - first_cell, grain,
                         [&](std::int64_t begin, std::int64_t stop) {
                           std::int64_t ids[8];
                           for (std::int64_t cell = begin; cell < stop; ++cell) {
                             if (!counts(mesh, piece, cell) ||
                                 (copies &&
                                  (piece.pole != 0 || copies->is_second(first_cell + cell))))
                               continue;
                             const int n = piece.vertex_ids(cell, ids);
                             for (int v = 0; v < n; ++v)
                               visit(first_cell + cell, first_vertex + ids[v]);
                           }
                         });
  }
}

} // namespace

VertexCells::VertexCells(const mesh::MeshView& mesh, const query::Seams* seams,
                         const ChartCopies* copies, const core::Threads& threads,
                         core::Memory& memory)
    : memory_(&memory), turn_(copies ? copies->turn : 0.0), end_(memory, INSITU_MEMORY_FRAME),
      cells_(memory, INSITU_MEMORY_FRAME) {
  const std::int64_t vertex_count = mesh.vertex_count();
  end_.resize_discard(std::size_t(vertex_count) + 1);
  std::fill(end_.begin(), end_.end(), 0);
  for_each_corner(mesh, copies, threads, [&](std::int64_t, std::int64_t vertex) {
    std::atomic_ref(end_[std::size_t(vertex) + 1]).fetch_add(1, std::memory_order_relaxed);
  });
  for (std::int64_t v = 0; v < vertex_count; ++v)
    end_[std::size_t(v) + 1] += end_[std::size_t(v)];
  cells_.resize_discard(std::size_t(end_[std::size_t(vertex_count)]));
  // Filling moves end_[v] from the list's begin to its end.
  for_each_corner(mesh, copies, threads, [&](std::int64_t cell, std::int64_t vertex) {
    const std::int64_t at =
        std::atomic_ref(end_[std::size_t(vertex)]).fetch_add(1, std::memory_order_relaxed);
    cells_[std::size_t(at)] = std::uint32_t(cell);
  });
  threads.parallel_for(vertex_count, grain, [&](std::int64_t begin, std::int64_t stop) {
    for (std::int64_t v = begin; v < stop; ++v)
      std::sort(cells_.data() + (v == 0 ? 0 : end_[std::size_t(v) - 1]),
                cells_.data() + end_[std::size_t(v)]);
  });
  if (copies)
    join(mesh, copies->joined, seams);
  else if (mesh.join_pieces && mesh.piece_count > 1)
    join(mesh, mesh::join_pieces(mesh, threads), seams);
}

/// Gives vertices that are one the cells of all of these.
void VertexCells::join(const mesh::MeshView& mesh, const mesh::JoinedVertices& joined,
                       const query::Seams* seams) {
  if (joined.end.empty())
    return;
  std::vector<std::vector<std::uint32_t>> lists(joined.end.size());
  std::vector<std::int64_t> sizes(std::size_t(mesh.vertex_count()));
  for (std::int64_t v = 0; v < mesh.vertex_count(); ++v)
    sizes[std::size_t(v)] = std::int64_t(of(v).size());
  for (std::size_t g = 0; g < lists.size(); ++g) {
    const auto first = joined.flat.begin() + (g == 0 ? 0 : joined.end[g - 1]);
    const auto last = joined.flat.begin() + joined.end[g];
    for (auto v = first; v != last; ++v)
      lists[g].insert(lists[g].end(), of(*v).begin(), of(*v).end());
    leave_out_copies(mesh, lists[g]);
    std::sort(lists[g].begin(), lists[g].end(), [&](std::uint32_t a, std::uint32_t b) {
      return seams ? seams->is_before(a, b) : a < b;
    });
    for (auto v = first; v != last; ++v)
      sizes[std::size_t(*v)] = -std::int64_t(g) - 1;
  }
  core::Buffer<std::uint32_t> cells = std::move(cells_);
  std::int64_t count = 0;
  for (const std::int64_t size : sizes)
    count += size >= 0 ? size : std::int64_t(lists[std::size_t(-size - 1)].size());
  cells_ = core::Buffer<std::uint32_t>(*memory_, INSITU_MEMORY_FRAME);
  cells_.resize_discard(std::size_t(count));
  std::int64_t from = 0, to = 0;
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    const std::int64_t end = end_[v];
    const std::uint32_t* begin = cells.data() + from;
    std::int64_t size = sizes[v];
    if (size < 0) {
      const std::vector<std::uint32_t>& list = lists[std::size_t(-size - 1)];
      begin = list.data();
      size = std::int64_t(list.size());
    }
    std::copy(begin, begin + size, cells_.data() + to);
    from = end;
    to += size;
    end_[v] = to;
  }
}

std::int64_t VertexCells::bytes_for(const mesh::MeshView& mesh, const core::Threads& threads) {
  std::atomic<std::int64_t> corners{0};
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    threads.parallel_for(mesh.first_cell[p + 1] - mesh.first_cell[p], grain,
                         [&](std::int64_t begin, std::int64_t stop) {
                           std::int64_t sum = 0;
                           for (std::int64_t cell = begin; cell < stop; ++cell)
                             sum += counts(mesh, piece, cell)
                                        ? mesh::vertex_count(piece.shape(cell))
                                        : 0;
                           corners += sum;
                         });
  }
  return (mesh.vertex_count() + 1) * std::int64_t(sizeof(std::int64_t)) +
         corners * std::int64_t(sizeof(std::uint32_t));
}

} // namespace insitu::render
