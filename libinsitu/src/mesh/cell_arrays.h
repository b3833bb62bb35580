#pragma once

#include <type_traits>

#include "mesh/view.h"

/// For functions that do nothing but prefetch: in GCC's analysis they have no effects, and calls of
/// those that are not inlined by then are dropped (seen with 12.2).
#define INSITU_PREFETCH [[gnu::always_inline]] inline

/// A piece's arrays for loops over many cells, whose number types and layout are chosen once and
/// not for each cell.
namespace insitu::mesh {

struct CellArrays {
  CellLayout layout = CellLayout::uniform;
  bool ids_are_int32 = true;
  int uniform_count = 0;       ///< vertices of a cell of UNIFORM layout
  bool ids_are_packed = false; ///< int32 ids side by side; they and the stride of points fit SIMD
  const std::byte* ids = nullptr;
  std::int64_t cell_stride = 0, id_stride = 0, base = 0;
  const std::byte* types = nullptr;   ///< MIXED
  const std::byte* offsets = nullptr; ///< MIXED
  std::int64_t types_stride = 0, offset_stride = 0;
  bool offset_is_int32 = false;
  std::uint32_t block_cells[2] = {1, 1};    ///< blocks: along i, j
  std::int64_t block_stride[3] = {0, 0, 0}; ///< blocks: bytes between vertices along i, j, k
  PointsView points;                        ///< evenly spaced, but for blocks
  bool interleaved = false;                 ///< x, y, z of a vertex are adjacent

  /// Bytes from one vertex to the next.
  std::int64_t point_stride() const { return points.layout.stride[0]; }

  /// False where there are none: points without arrays of their own, or not evenly spaced. Then
  /// PieceView is the way.
  static bool make(const PieceView& piece, CellArrays& out);
};

// One type a layout, all with the same members:
//   offsets(m, cell, out)   bytes from component[] to the cell's vertices, in VTK's order; how many
//   prefetch(m, cell)       asks for what offsets() reads
//   least, most             vertices of a cell
// mesh/offsets_simd.h does the same for loops of SIMD.

template <class Index, int count>
struct UniformLayout {
  static constexpr bool may_be_packed = std::is_same_v<Index, std::int32_t>;
  static constexpr int least = count, most = count;
  static int offsets(const CellArrays& m, std::int64_t cell, std::int64_t* out) {
    const std::byte* ids = m.ids + cell * m.cell_stride;
    for (int v = 0; v < count; ++v)
      out[v] = (std::int64_t(load_as<Index>(ids + v * m.id_stride)) - m.base) * m.point_stride();
    return count;
  }
  INSITU_PREFETCH static void prefetch(const CellArrays& m, std::int64_t cell) {
    __builtin_prefetch(m.ids + cell * m.cell_stride);
  }
};

/// Types, offsets and ids.
template <class Index>
struct MixedLayout {
  static constexpr int least = 4, most = 8;
  static int offsets(const CellArrays& m, std::int64_t cell, std::int64_t* out) {
    constexpr std::uint8_t counts[16] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 8, 8, 6, 5, 0};
    const int count = counts[std::uint8_t(m.types[cell * m.types_stride]) & 15];
    const std::byte* ids =
        m.ids +
        (load_index(m.offsets + cell * m.offset_stride, m.offset_is_int32) - m.base) * m.id_stride;
    for (int v = 0; v < count; ++v)
      out[v] = (std::int64_t(load_as<Index>(ids + v * m.id_stride)) - m.base) * m.point_stride();
    return count;
  }
  INSITU_PREFETCH static void prefetch(const CellArrays& m, std::int64_t cell) {
    __builtin_prefetch(m.types + cell * m.types_stride);
    __builtin_prefetch(m.offsets + cell * m.offset_stride);
  }
};

/// Eight ids a cell, -1 behind the last.
template <class Index>
struct PaddedLayout {
  static constexpr int least = 4, most = 8;
  static int offsets(const CellArrays& m, std::int64_t cell, std::int64_t* out) {
    const std::byte* ids = m.ids + cell * m.cell_stride;
    int count = 0;
    for (; count < 8; ++count) {
      const std::int64_t id = std::int64_t(load_as<Index>(ids + count * m.id_stride)) - m.base;
      if (id < 0)
        break;
      out[count] = id * m.point_stride();
    }
    return count;
  }
  INSITU_PREFETCH static void prefetch(const CellArrays& m, std::int64_t cell) {
    __builtin_prefetch(m.ids + cell * m.cell_stride);
  }
};

/// Implicit hexahedra of a block with vertices of its own.
struct BlockLayout {
  static constexpr int least = 8, most = 8;
  static int offsets(const CellArrays& m, std::int64_t cell, std::int64_t* out) {
    const auto c = std::uint32_t(cell);
    const std::uint32_t row = c / m.block_cells[0];
    const std::int64_t i = c - row * m.block_cells[0], j = row % m.block_cells[1],
                       k = row / m.block_cells[1];
    const std::int64_t* s = m.block_stride;
    const std::int64_t o = i * s[0] + j * s[1] + k * s[2];
    out[0] = o;
    out[1] = o + s[0];
    out[2] = o + s[0] + s[1];
    out[3] = o + s[1];
    for (int v = 0; v < 4; ++v)
      out[4 + v] = out[v] + s[2];
    return 8;
  }
  INSITU_PREFETCH static void prefetch(const CellArrays&, std::int64_t) {}
};

/// f.operator()<Layout, Real>() for the arrays' layout and numbers: picks a loop out of a template.
template <class F>
auto with_layout(const CellArrays& m, F&& f) {
  const auto real = [&]<class Layout>() {
    return m.points.is_float32 ? f.template operator()<Layout, float>()
                               : f.template operator()<Layout, double>();
  };
  const auto index = [&]<class Index>() {
    if (m.layout == CellLayout::mixed)
      return real.template operator()<MixedLayout<Index>>();
    if (m.layout == CellLayout::padded)
      return real.template operator()<PaddedLayout<Index>>();
    switch (m.uniform_count) {
    case 4:
      return real.template operator()<UniformLayout<Index, 4>>();
    case 5:
      return real.template operator()<UniformLayout<Index, 5>>();
    case 6:
      return real.template operator()<UniformLayout<Index, 6>>();
    default:
      return real.template operator()<UniformLayout<Index, 8>>();
    }
  };
  if (m.layout == CellLayout::block)
    return real.template operator()<BlockLayout>();
  return m.ids_are_int32 ? index.template operator()<std::int32_t>()
                         : index.template operator()<std::int64_t>();
}

} // namespace insitu::mesh
