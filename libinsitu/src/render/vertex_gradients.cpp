#include "render/vertex_gradients.h"

#include <algorithm>

#include "render/vertex_cells.h"

namespace insitu::render {

using math::Vec3d;

namespace {

/// The parametric coordinates of a vertex. Of a pyramid's apex, where they are singular, of a place
/// below it.
Vec3d corner_of(mesh::Shape shape, int v) {
  constexpr double turning[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  constexpr double wedge[3][2] = {{0, 0}, {1, 0}, {0, 1}};
  switch (shape) {
  case mesh::Shape::tetrahedron:
    return {double(v == 1), double(v == 2), double(v == 3)};
  case mesh::Shape::voxel:
    return {double(v & 1), double(v >> 1 & 1), double(v >> 2)};
  case mesh::Shape::wedge:
    return {wedge[v % 3][0], wedge[v % 3][1], double(v / 3)};
  case mesh::Shape::pyramid:
    if (v == 4)
      return {0.5, 0.5, 0.75};
    break;
  default:
    break;
  }
  return {turning[v % 4][0], turning[v % 4][1], double(v / 4)};
}

} // namespace

VertexGradients::VertexGradients(const mesh::MeshView& mesh, const ScalarField& vertex_field,
                                 const core::Threads& threads, core::Memory& memory)
    : memory_(&memory), gradients_(memory, INSITU_MEMORY_FRAME) {
  gradients_.resize_discard(std::size_t(mesh.vertex_count()));
  refresh(mesh, vertex_field, threads);
}

void VertexGradients::refresh(const mesh::MeshView& mesh, const ScalarField& vertex_field,
                              const core::Threads& threads) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    average_piece(mesh, vertex_field, p, threads);
}

void VertexGradients::average_piece(const mesh::MeshView& mesh, const ScalarField& field,
                                    std::int32_t p, const core::Threads& threads) {
  const VertexCells around(mesh, p, threads, *memory_);
  Vec3d* out = gradients_.data() + mesh.first_vertex[p];
  const std::int64_t vertex_count = mesh.first_vertex[p + 1] - mesh.first_vertex[p];
  threads.parallel_for(vertex_count, 1024, [&](std::int64_t begin, std::int64_t end) {
    mesh::CellVertices cell;
    double values[8];
    for (std::int64_t v = begin; v < end; ++v) {
      Vec3d sum;
      int count = 0;
      for (const std::uint32_t local : around.of(v)) {
        mesh::gather(mesh, mesh.first_cell[p] + local, cell);
        int corner = 0;
        for (int k = 0; k < cell.count; ++k) {
          values[k] = field.load(p, cell.ids[k]);
          if (cell.ids[k] == v)
            corner = k;
        }
        const Vec3d g = cells::gradient(cell.shape, cell.x, values, corner_of(cell.shape, corner));
        // Cells without volume there have none.
        if (!std::isfinite(g.x) || !std::isfinite(g.y) || !std::isfinite(g.z))
          continue;
        sum += g;
        ++count;
      }
      out[v] = count > 0 ? sum / double(count) : Vec3d{};
    }
  });
}

Vec3d VertexGradients::at(const mesh::MeshView& mesh, std::int64_t flat,
                          const Vec3d& parametric) const {
  const std::int32_t piece = mesh.piece_count == 1 ? 0 : mesh.piece_of(flat);
  const mesh::PieceView& cells_of = mesh.pieces[piece];
  const std::int64_t local = flat - mesh.first_cell[piece];
  std::int64_t ids[8];
  double weights[8];
  const int n = cells_of.vertex_ids(local, ids);
  cells::shape_functions(cells_of.shape(local), parametric, weights);
  Vec3d sum;
  for (int v = 0; v < n; ++v)
    sum += weights[v] * gradients_[std::size_t(mesh.first_vertex[piece] + ids[v])];
  return sum;
}

} // namespace insitu::render
