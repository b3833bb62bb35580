#pragma once

#include "accel/cell_boxes.h"

/// Where the vertices of a cell lie, one type a layout of cells, all with the same members:
///   offsets(m, cell, out)   bytes from m.component to the cell's vertices; returns how many
///   prefetch(m, cell)       asks for what offsets() reads
namespace insitu::accel {

/// One shape. count: its vertices.
template <class Index, int count>
struct UniformLayout {
  static constexpr int least = count, most = count;
  static int offsets(const CellBoxes::Arrays& m, std::int64_t cell, std::int64_t* out) {
    const std::byte* ids = m.ids + cell * m.cell_stride;
    for (int v = 0; v < count; ++v)
      out[v] =
          (std::int64_t(mesh::load_as<Index>(ids + v * m.id_stride)) - m.base) * m.point_stride;
    return count;
  }
  static void prefetch(const CellBoxes::Arrays& m, std::int64_t cell) {
    __builtin_prefetch(m.ids + cell * m.cell_stride);
  }
};

/// Types, offsets and ids.
template <class Index>
struct MixedLayout {
  static constexpr int least = 4, most = 8;
  static int offsets(const CellBoxes::Arrays& m, std::int64_t cell, std::int64_t* out) {
    constexpr std::uint8_t counts[16] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 8, 8, 6, 5, 0};
    const int count = counts[std::uint8_t(m.types[cell * m.types_stride]) & 15];
    const std::byte* ids =
        m.ids + (mesh::load_index(m.offsets + cell * m.offset_stride, m.offset_is_int32) - m.base) *
                    m.id_stride;
    for (int v = 0; v < count; ++v)
      out[v] =
          (std::int64_t(mesh::load_as<Index>(ids + v * m.id_stride)) - m.base) * m.point_stride;
    return count;
  }
  static void prefetch(const CellBoxes::Arrays& m, std::int64_t cell) {
    __builtin_prefetch(m.types + cell * m.types_stride);
    __builtin_prefetch(m.offsets + cell * m.offset_stride);
  }
};

/// Eight ids a cell, -1 behind the last.
template <class Index>
struct PaddedLayout {
  static constexpr int least = 4, most = 8;
  static int offsets(const CellBoxes::Arrays& m, std::int64_t cell, std::int64_t* out) {
    const std::byte* ids = m.ids + cell * m.cell_stride;
    int count = 0;
    for (; count < 8; ++count) {
      const std::int64_t id =
          std::int64_t(mesh::load_as<Index>(ids + count * m.id_stride)) - m.base;
      if (id < 0)
        break;
      out[count] = id * m.point_stride;
    }
    return count;
  }
  static void prefetch(const CellBoxes::Arrays& m, std::int64_t cell) {
    __builtin_prefetch(m.ids + cell * m.cell_stride);
  }
};

/// Implicit hexahedra of a block with vertices of its own.
struct BlockLayout {
  static constexpr int least = 8, most = 8;
  static int offsets(const CellBoxes::Arrays& m, std::int64_t cell, std::int64_t* out) {
    const auto c = std::uint32_t(cell);
    const std::uint32_t row = c / m.block_cells[0];
    const std::int64_t i = c - row * m.block_cells[0], j = row % m.block_cells[1],
                       k = row / m.block_cells[1];
    const std::int64_t* s = m.block_stride;
    const std::int64_t o = i * s[0] + j * s[1] + k * s[2];
    out[0] = o;
    out[1] = o + s[0];
    out[2] = o + s[1];
    out[3] = o + s[0] + s[1];
    for (int v = 0; v < 4; ++v)
      out[4 + v] = out[v] + s[2];
    return 8;
  }
  static void prefetch(const CellBoxes::Arrays&, std::int64_t) {}
};

} // namespace insitu::accel
