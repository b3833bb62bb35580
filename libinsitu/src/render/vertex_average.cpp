#include "render/vertex_average.h"

#include <algorithm>
#include <atomic>
#include <limits>

namespace insitu::render {

VertexAverage::VertexAverage(const mesh::MeshView& mesh, const ScalarField& cell_field,
                             const core::Threads& threads, core::Memory& memory)
    : name_(cell_field.field.name), values_(memory, INSITU_MEMORY_FRAME) {
  values_.resize_discard(std::size_t(mesh.vertex_count()));
  bases_.reserve(std::size_t(mesh.piece_count));
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    bases_.push_back(reinterpret_cast<const std::byte*>(values_.data() + mesh.first_vertex[p]));
    mesh::FieldPieceView view;
    view.component = &bases_[std::size_t(p)];
    view.layout.count = mesh.first_vertex[p + 1] - mesh.first_vertex[p];
    view.layout.stride[0] = sizeof(double);
    views_.push_back(view);
    average_piece(mesh, cell_field, p, threads, memory);
  }
}

ScalarField VertexAverage::field() const {
  return {{name_.c_str(), INSITU_VERTEX, 1, views_.data()}, 0};
}

// Cells around each vertex are listed first, each list in ascending order, so that sums do not
// depend on which thread came first.
void VertexAverage::average_piece(const mesh::MeshView& mesh, const ScalarField& cell_field,
                                  std::int32_t p, const core::Threads& threads,
                                  core::Memory& memory) {
  constexpr std::int64_t grain = 4096;
  const mesh::PieceView& piece = mesh.pieces[p];
  const std::int64_t cell_count = mesh.first_cell[p + 1] - mesh.first_cell[p];
  const std::int64_t vertex_count = mesh.first_vertex[p + 1] - mesh.first_vertex[p];
  core::Buffer<std::int64_t> end(memory, INSITU_MEMORY_FRAME); // of each vertex's list
  end.resize_discard(std::size_t(vertex_count) + 1);
  std::fill(end.begin(), end.end(), 0);

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
    std::atomic_ref(end[std::size_t(vertex) + 1]).fetch_add(1, std::memory_order_relaxed);
  });
  for (std::int64_t v = 0; v < vertex_count; ++v)
    end[std::size_t(v) + 1] += end[std::size_t(v)];
  core::Buffer<std::uint32_t> cells(memory, INSITU_MEMORY_FRAME); // flat ids fit, as in the tree
  cells.resize_discard(std::size_t(end[std::size_t(vertex_count)]));
  // Filling moves end[v] from the list's begin to its end.
  for_each_corner([&](std::int64_t cell, std::int64_t vertex) {
    const std::int64_t at =
        std::atomic_ref(end[std::size_t(vertex)]).fetch_add(1, std::memory_order_relaxed);
    cells[std::size_t(at)] = std::uint32_t(cell);
  });

  double* out = values_.data() + mesh.first_vertex[p];
  threads.parallel_for(vertex_count, grain, [&](std::int64_t begin, std::int64_t stop) {
    for (std::int64_t v = begin; v < stop; ++v) {
      std::uint32_t* first = cells.data() + (v == 0 ? 0 : end[std::size_t(v) - 1]);
      std::uint32_t* last = cells.data() + end[std::size_t(v)];
      std::sort(first, last);
      double sum = 0.0;
      for (const std::uint32_t* cell = first; cell != last; ++cell)
        sum += cell_field.load(p, *cell);
      out[v] =
          first == last ? std::numeric_limits<double>::quiet_NaN() : sum / double(last - first);
    }
  });
}

} // namespace insitu::render
