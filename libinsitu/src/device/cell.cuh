#pragma once

#include <cstddef>
#include <cstdint>

#include "device/kernel_mesh.h"
#include "math/hd.h"
#include "math/vec.h"

/// Cells in kernels: where a cell lies, and its vertices in registers.
namespace insitu::device {

using math::Vec3d;
using mesh::Shape;

/// A cell's place: in the mesh's only piece, whose view lies among the kernel's arguments, where S
/// is the shape of all cells; in any piece where S is none.
struct CellPlace {
  const mesh::PieceView& piece;
  std::int32_t number; ///< of the piece
  std::int64_t cell;
};
template <Shape S>
INSITU_HD inline CellPlace place_of(const KernelMesh& mesh, std::uint32_t flat) {
  if constexpr (S != Shape::none) {
    return {mesh.piece, 0, flat};
  } else {
    const std::int32_t p = mesh.view.piece_of(flat);
    return {mesh.view.pieces[p], p, flat - mesh.view.first_cell[p]};
  }
}

/// Calls f.operator()<Shape>() for the cell's shape; S: see CellPlace.
template <Shape S, class F>
INSITU_HD inline auto for_shape(const CellPlace& at, F&& f) {
  if constexpr (S != Shape::none) {
    return f.template operator()<S>();
  } else {
    switch (at.piece.shape(at.cell)) {
    case Shape::tetrahedron:
      return f.template operator()<Shape::tetrahedron>();
    case Shape::voxel:
      return f.template operator()<Shape::voxel>();
    case Shape::wedge:
      return f.template operator()<Shape::wedge>();
    case Shape::pyramid:
      return f.template operator()<Shape::pyramid>();
    default:
      return f.template operator()<Shape::hexahedron>();
    }
  }
}

/// Whether all reads of a cell's ids and coordinates are aligned, and places follow from strides.
INSITU_HD inline bool reads_plainly(const mesh::PieceView& piece) {
  const auto bits = [](const auto* p) { return reinterpret_cast<std::uintptr_t>(p); };
  const mesh::PointsView& points = piece.points;
  const std::uintptr_t ids =
      bits(piece.connectivity.data) | std::uintptr_t(piece.connectivity.stride | piece.id_stride);
  const std::uintptr_t coordinates = bits(points.component[0]) | bits(points.component[1]) |
                                     bits(points.component[2]) |
                                     std::uintptr_t(points.layout.stride[0]);
  return !piece.implicit_points && points.layout.linear &&
         piece.layout != mesh::CellLayout::block &&
         ids % (piece.connectivity.is_int32 ? 4u : 8u) == 0 &&
         coordinates % (points.is_float32 ? 4u : 8u) == 0;
}

/// The general way, in a function of its own, so that kernels stay small.
INSITU_HD __attribute__((noinline)) inline void
gather_any(const mesh::PieceView& piece, std::int64_t cell, std::int64_t* ids, Vec3d* x) {
  const int count = piece.vertex_ids(cell, ids);
  for (int v = 0; v < count; ++v)
    x[v] = piece.point(ids[v]);
}

/// Vertices in registers: their number is known to the compiler, and the choice among number types
/// is made once a cell.
template <Shape S>
struct Gathered {
  static constexpr int count = mesh::vertex_count(S);
  std::int64_t ids[count];
  Vec3d x[count];

  INSITU_HD explicit Gathered(const CellPlace& at) {
    const mesh::PieceView& piece = at.piece;
    if (!reads_plainly(piece)) {
      std::int64_t any_ids[8];
      Vec3d any_x[8];
      gather_any(piece, at.cell, any_ids, any_x);
      INSITU_UNROLL
      for (int v = 0; v < count; ++v) {
        ids[v] = any_ids[v];
        x[v] = any_x[v];
      }
      return;
    }
    const std::byte* base =
        piece.layout == mesh::CellLayout::mixed
            ? piece.connectivity.data +
                  mesh::from_base(piece.offsets.load(at.cell), piece.index_base) * piece.id_stride
            : piece.connectivity.data + at.cell * piece.connectivity.stride;
    piece.connectivity.is_int32 ? load_ids<std::int32_t>(piece, base)
                                : load_ids<std::int64_t>(piece, base);
    piece.points.is_float32 ? load_points<float>(piece.points) : load_points<double>(piece.points);
  }

private:
  template <class Index>
  INSITU_HD void load_ids(const mesh::PieceView& piece, const std::byte* base) {
    INSITU_UNROLL
    for (int v = 0; v < count; ++v)
      ids[v] = std::int64_t(*reinterpret_cast<const Index*>(base + v * piece.id_stride)) -
               piece.index_base;
  }
  template <class Real>
  INSITU_HD void load_points(const mesh::PointsView& points) {
    INSITU_UNROLL
    for (int v = 0; v < count; ++v) {
      const std::int64_t o = ids[v] * points.layout.stride[0];
      x[v] = {double(*reinterpret_cast<const Real*>(points.component[0] + o)),
              double(*reinterpret_cast<const Real*>(points.component[1] + o)),
              double(*reinterpret_cast<const Real*>(points.component[2] + o))};
    }
  }
};

/// Calls f.operator()<Shape>() for the shape that kernels are made for.
template <class F>
void with_shape(Shape shape, F&& f) {
  switch (shape) {
  case Shape::tetrahedron:
    return f.template operator()<Shape::tetrahedron>();
  case Shape::hexahedron:
    return f.template operator()<Shape::hexahedron>();
  default:
    return f.template operator()<Shape::none>();
  }
}

} // namespace insitu::device
