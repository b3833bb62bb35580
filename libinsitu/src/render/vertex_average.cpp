#include "render/vertex_average.h"

#include <limits>

#include "render/vertex_cells.h"

namespace insitu::render {

VertexAverage::VertexAverage(const mesh::MeshView& mesh, const ScalarField& cell_field,
                             const core::Threads& threads, core::Memory& memory)
    : memory_(&memory), name_(cell_field.field.name), values_(memory, INSITU_MEMORY_FRAME) {
  values_.resize_discard(std::size_t(mesh.vertex_count()));
  bases_.reserve(std::size_t(mesh.piece_count));
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    bases_.push_back(reinterpret_cast<const std::byte*>(values_.data() + mesh.first_vertex[p]));
    mesh::FieldPieceView view;
    view.component = &bases_[std::size_t(p)];
    view.layout.count = mesh.first_vertex[p + 1] - mesh.first_vertex[p];
    view.layout.stride[0] = sizeof(double);
    views_.push_back(view);
  }
  refresh(mesh, cell_field, threads);
}

void VertexAverage::refresh(const mesh::MeshView& mesh, const ScalarField& cell_field,
                            const core::Threads& threads) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    average_piece(mesh, cell_field, p, threads);
}

ScalarField VertexAverage::field() const {
  return {{name_.c_str(), INSITU_VERTEX, 1, views_.data()}, 0};
}

void VertexAverage::average_piece(const mesh::MeshView& mesh, const ScalarField& cell_field,
                                  std::int32_t p, const core::Threads& threads) {
  const VertexCells around(mesh, p, threads, *memory_);
  double* out = values_.data() + mesh.first_vertex[p];
  const std::int64_t vertex_count = mesh.first_vertex[p + 1] - mesh.first_vertex[p];
  threads.parallel_for(vertex_count, 4096, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      const std::span<const std::uint32_t> cells = around.of(v);
      double sum = 0.0;
      for (const std::uint32_t cell : cells)
        sum += cell_field.load(p, cell);
      out[v] =
          cells.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / double(cells.size());
    }
  });
}

} // namespace insitu::render
