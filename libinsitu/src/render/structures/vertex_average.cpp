#include "render/structures/vertex_average.h"

#include <cmath>
#include <limits>
#include <utility>

namespace insitu::render {

VertexAverage::VertexAverage(const mesh::MeshView& mesh, const ScalarField& cell_field,
                             const VertexCells& around, const core::Threads& threads,
                             core::Memory& memory)
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
  }
  refresh(mesh, cell_field, around, threads);
}

void VertexAverage::refresh(const mesh::MeshView& mesh, const ScalarField& cell_field,
                            const VertexCells& around, const core::Threads& threads) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const std::int64_t first = mesh.first_vertex[p];
    threads.parallel_for(
        mesh.first_vertex[p + 1] - first, 4096, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t v = first + begin; v < first + end; ++v) {
            const std::span<const std::uint32_t> cells = around.of(v);
            double sum = 0.0;
            std::int64_t count = 0, last = -1;
            for (const std::uint32_t flat : cells) {
              const std::int32_t of = mesh.piece_of(flat);
              const std::int64_t cell = std::int64_t(flat) - mesh.first_cell[of];
              const std::uint32_t* const part_of = mesh.pieces[of].part_of;
              const std::int64_t whole = mesh.first_cell[of] + (part_of ? part_of[cell] : cell);
              if (std::exchange(last, whole) == whole)
                continue; // another part of the same cell
              const double value = cell_field.load(of, cell);
              if ((std::isnan(value) && cell_field.field.has_blanks) ||
                  (!std::isfinite(value) && !mesh.pieces[of].exists(cell)))
                continue; // none, or a ghost's, which may be anything
              sum += value;
              ++count;
            }
            values_[std::size_t(v)] =
                count > 0 ? sum / double(count) : std::numeric_limits<double>::quiet_NaN();
          }
        });
  }
}

ScalarField VertexAverage::field() const {
  return {{name_.c_str(), INSITU_VERTEX, 1, views_.data()}, 0};
}

} // namespace insitu::render
