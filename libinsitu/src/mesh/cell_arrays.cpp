#include "mesh/cell_arrays.h"

#include <utility>

namespace insitu::mesh {

bool CellArrays::make(const PieceView& p, CellArrays& m) {
  const ItemLayout& layout = p.points.layout;
  const bool block = p.layout == CellLayout::block;
  if (p.implicit_points || !p.shares_vertices() || (!layout.linear && !block))
    return false;
  m.layout = p.layout;
  if (block) {
    if (!layout.linear &&
        (layout.extent[0] != p.block_vertices[0] || layout.extent[1] != p.block_vertices[1]))
      return false;
    for (int a = 0; a < 2; ++a)
      m.block_cells[a] = std::uint32_t(p.block_vertices[a] - 1);
    m.block_stride[0] = layout.stride[0];
    m.block_stride[1] = layout.linear ? p.block_vertices[0] * layout.stride[0] : layout.stride[1];
    m.block_stride[2] = layout.linear ? p.block_vertices[1] * m.block_stride[1] : layout.stride[2];
  } else {
    m.uniform_count = vertex_count(p.uniform_shape);
    m.ids = p.connectivity.data;
    m.ids_are_int32 = p.connectivity.is_int32;
    m.cell_stride = p.connectivity.stride;
    m.id_stride = p.id_stride;
    m.base = p.index_base;
    m.ids_are_packed = m.ids_are_int32 && m.id_stride == 4 && std::in_range<std::int32_t>(m.base) &&
                       std::in_range<std::int32_t>(layout.stride[0]);
    m.types = p.types;
    m.types_stride = p.types_stride;
    m.offsets = p.offsets.data;
    m.offset_stride = p.offsets.stride;
    m.offset_is_int32 = p.offsets.is_int32;
  }
  m.points = p.points;
  const std::int64_t size = m.points.is_float32 ? 4 : 8;
  const std::byte* const* const of = m.points.component;
  m.interleaved = of[1] - of[0] == size && of[2] - of[1] == size;
  return true;
}

} // namespace insitu::mesh
