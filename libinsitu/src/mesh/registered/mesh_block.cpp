/// Implicit blocks.
#include <algorithm>
#include <cmath>

#include "core/caller_struct.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

using core::Error;

void Mesh::set_block(std::int32_t piece, const insitu_block* given) {
  const std::string name = "mesh '" + name_ + "', piece " + std::to_string(piece) + " block";
  const auto refuse = [&](const std::string& what) {
    throw Error(INSITU_ERROR_ARGUMENT, name + ": " + what);
  };
  refuse_if_adaptive(name);
  const insitu_block copy = core::from_caller(given, name), *const block = &copy;
  if (block->kind < INSITU_BLOCK_UNIFORM || block->kind > INSITU_BLOCK_CURVILINEAR)
    refuse("unknown kind " + std::to_string(int(block->kind)));
  const int dimensions = block->dimensions;
  if (dimensions != 2 && dimensions != 3)
    refuse("dimensions " + std::to_string(dimensions) + ", 2 or 3 expected");
  if (dimensions == 2 && (block->vertices[2] < 0 || block->vertices[2] > 1))
    refuse(std::to_string(block->vertices[2]) +
           " vertices along axis 2; a flat block (dimensions 2) has one");
  PieceView v;
  v.layout = CellLayout::block;
  v.uniform_shape = Shape::hexahedron;
  v.cell_count = v.vertex_count = 1;
  v.block_vertices[2] = 1;
  ExternalArray axes[3];
  for (int a = 0; a < dimensions; ++a) {
    const std::int64_t n = block->vertices[a];
    if (n < 0 || n > (std::int64_t(1) << 20))
      refuse(std::to_string(n) + " vertices along axis " + std::to_string(a) +
             ", 0 to 1048576 expected");
    v.block_vertices[a] = n;
    v.cell_count *= std::max<std::int64_t>(n - 1, 0);
    v.vertex_count *= n;
    v.origin[a] = block->origin[a];
    v.spacing[a] = block->spacing[a];
    v.block_first[a] = block->first[a];
    if (block->kind == INSITU_BLOCK_UNIFORM && n > 1 &&
        (block->spacing[a] == 0.0 || !std::isfinite(block->spacing[a])))
      refuse("spacing along axis " + std::to_string(a) + " is " +
             std::to_string(block->spacing[a]));
    constexpr std::int64_t farthest = std::int64_t(1) << 52; // which doubles count exactly
    if (block->first[a] < -farthest || block->first[a] > farthest)
      refuse("first vertex " + std::to_string(block->first[a]) + " along axis " +
             std::to_string(a));
    if (block->first[a] != 0 && block->kind != INSITU_BLOCK_UNIFORM)
      refuse("first vertex " + std::to_string(block->first[a]) + " along axis " +
             std::to_string(a) + "; only a uniform block's vertices count from its origin");
    if (block->kind != INSITU_BLOCK_RECTILINEAR)
      continue;
    const std::string one = name + ", coordinates of axis " + std::to_string(a);
    axes[a] = adopt(&block->coordinates[a], one);
    require_real(axes[a], one);
    if (axes[a].components != 1)
      refuse("coordinates of axis " + std::to_string(a) + ": " +
             std::to_string(axes[a].components) + " components, 1 expected");
    if (axes[a].layout.count < n || !axes[a].layout.linear || axes[a].type != axes[0].type)
      refuse("coordinates of axis " + std::to_string(a) + ": " +
             std::to_string(axes[a].layout.count) + " values for " + std::to_string(n) +
             " vertices, evenly spaced and of one type, expected");
    v.axis[a] = axes[a].data;
    v.axis_stride[a] = axes[a].layout.stride[0];
    v.axis_is_float32 = axes[a].type == INSITU_FLOAT32;
  }
  v.implicit_points = block->kind != INSITU_BLOCK_CURVILINEAR;
  Piece& p = piece_for(piece);
  p.set_cells_view(v);
  p.given = copy;
  std::copy(axes, axes + 3, p.axes);
  p.is_block = true;
  if (dimensions == 2)
    p.flat_cells = {FlatCells::Kind::block, 9};
  pending_ |= INSITU_CHANGED_ALL;
}

} // namespace insitu::mesh
