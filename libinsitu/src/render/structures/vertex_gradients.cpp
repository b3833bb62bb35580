#include "render/structures/vertex_gradients.h"

#include <algorithm>
#include <atomic>
#include <cmath>

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

/// Which corner of a cell a vertex is, by its number in the cell's piece (-1: it is not of that
/// piece) or by its place, which may be whole turns away.
int corner_at(const mesh::CellVertices& cell, std::int64_t vertex, const Vec3d& here, double turn) {
  for (int k = 0; k < cell.count; ++k)
    if (vertex >= 0 ? cell.ids[k] == vertex : cell.x[k] == here)
      return k;
  for (int k = 0; k < cell.count && turn > 0; ++k) {
    const Vec3d& x = cell.x[k];
    if (x.y == here.y && x.z == here.z &&
        std::fabs(std::remainder(x.x - here.x, turn)) < 1e-9 * turn)
      return k;
  }
  return 0;
}

} // namespace

VertexGradients::VertexGradients(const mesh::MeshView& mesh, core::Memory& memory)
    : gradients_(memory, INSITU_MEMORY_FRAME), is_known_(memory, INSITU_MEMORY_FRAME) {
  gradients_.resize_discard(std::size_t(mesh.vertex_count()));
  is_known_.resize_discard(std::size_t(mesh.vertex_count()));
  forget();
}

void VertexGradients::forget() {
  std::fill(is_known_.begin(), is_known_.end(), std::uint8_t(0));
}

Vec3d VertexGradients::of(const mesh::MeshView& mesh, const ScalarField& field,
                          const VertexCells& around, std::int32_t p, std::int64_t vertex) const {
  const std::int64_t flat_vertex = mesh.first_vertex[p] + vertex;
  Vec3d& kept = gradients_[std::size_t(flat_vertex)];
  const std::atomic_ref known(is_known_[std::size_t(flat_vertex)]);
  // Two threads may find the same at once: they write the same bits.
  const std::atomic_ref x(kept.x), y(kept.y), z(kept.z);
  if (known.load(std::memory_order_acquire))
    return {x.load(std::memory_order_relaxed), y.load(std::memory_order_relaxed),
            z.load(std::memory_order_relaxed)};
  const Vec3d here = mesh.pieces[p].point(vertex);
  mesh::CellVertices cell;
  double values[8];
  Vec3d sum;
  int count = 0;
  for (const std::uint32_t flat : around.of(flat_vertex)) {
    mesh::gather(mesh, flat, cell);
    for (int k = 0; k < cell.count; ++k)
      values[k] = field.load(cell.piece, cell.ids[k]);
    const int corner = corner_at(cell, cell.piece == p ? vertex : -1, here, around.turn());
    const Vec3d g = cells::gradient(cell.shape, cell.x, values, corner_of(cell.shape, corner));
    // Cells without volume there have none.
    if (!std::isfinite(g.x) || !std::isfinite(g.y) || !std::isfinite(g.z))
      continue;
    sum += g;
    ++count;
  }
  const Vec3d found = count > 0 ? sum / double(count) : Vec3d{};
  x.store(found.x, std::memory_order_relaxed);
  y.store(found.y, std::memory_order_relaxed);
  z.store(found.z, std::memory_order_relaxed);
  known.store(1, std::memory_order_release);
  return found;
}

Vec3d VertexGradients::at(const mesh::MeshView& mesh, const ScalarField& field,
                          const VertexCells& around, std::int64_t flat,
                          const Vec3d& parametric) const {
  const std::int32_t piece = mesh.piece_of(flat);
  const mesh::PieceView& cells_of = mesh.pieces[piece];
  const std::int64_t local = flat - mesh.first_cell[piece];
  std::int64_t ids[8];
  double weights[8];
  const int n = cells_of.vertex_ids(local, ids);
  cells::shape_functions(cells_of.shape(local), parametric, weights);
  Vec3d sum;
  for (int v = 0; v < n; ++v)
    sum += weights[v] * of(mesh, field, around, piece, ids[v]);
  return sum;
}

} // namespace insitu::render
