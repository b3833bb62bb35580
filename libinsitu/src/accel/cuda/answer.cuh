#pragma once

#include "accel/cuda/locate_kernels.h"
#include "accel/locator.h"
#include "cells/kernels/contain_filter.h"
#include "cells/kernels/kernels.h"
#include "cells/kernels/on_feature.h"

/// What locating kernels share: gathering a cell, proofs, writing answers.
namespace insitu::accel::cuda {

using math::Vec3d;
using mesh::Shape;

__device__ inline Vec3d point_of(const LocateArguments& a, std::uint32_t i) {
  const double* p = a.points + 3 * std::size_t(i);
  return {p[0], p[1], p[2]};
}

/// A cell's place: of the mesh's only piece, whose view lies among the kernel's arguments where S
/// is the shape of all cells; or S is none.
struct CellPlace {
  const mesh::PieceView& piece;
  std::int32_t number; ///< of the piece
  std::int64_t cell;
};
template <Shape S>
__device__ inline CellPlace place_of(const LocateArguments& a, std::uint32_t flat) {
  if constexpr (S != Shape::none) {
    return {a.piece, 0, flat};
  } else {
    const std::int32_t p = a.mesh.piece_of(flat);
    return {a.mesh.pieces[p], p, flat - a.mesh.first_cell[p]};
  }
}

/// Calls f.operator()<Shape>() for the cell's shape; S: see CellPlace.
template <Shape S, class F>
__device__ inline auto for_shape(const CellPlace& at, F&& f) {
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
__device__ inline bool reads_plainly(const mesh::PieceView& piece) {
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
static __device__ __noinline__ void gather_any(const mesh::PieceView& piece, std::int64_t cell,
                                               std::int64_t* ids, Vec3d* x) {
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

  __device__ explicit Gathered(const CellPlace& at) {
    const mesh::PieceView& piece = at.piece;
    if (!reads_plainly(piece)) {
      std::int64_t any_ids[8];
      Vec3d any_x[8];
      gather_any(piece, at.cell, any_ids, any_x);
#pragma unroll
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
  __device__ void load_ids(const mesh::PieceView& piece, const std::byte* base) {
#pragma unroll
    for (int v = 0; v < count; ++v)
      ids[v] = std::int64_t(*reinterpret_cast<const Index*>(base + v * piece.id_stride)) -
               piece.index_base;
  }
  template <class Real>
  __device__ void load_points(const mesh::PointsView& points) {
#pragma unroll
    for (int v = 0; v < count; ++v) {
      const std::int64_t o = ids[v] * points.layout.stride[0];
      x[v] = {double(*reinterpret_cast<const Real*>(points.component[0] + o)),
              double(*reinterpret_cast<const Real*>(points.component[1] + o)),
              double(*reinterpret_cast<const Real*>(points.component[2] + o))};
    }
  }
};

/// What plain double tells of a point and a cell.
enum class Proof : std::uint8_t { outside, inside, undecided, on_vertex };

/// vertex: the first that p is, where that is all that is known.
template <Shape S>
__device__ inline Proof prove(const LocateArguments& a, std::uint32_t flat, const Vec3d& p,
                              int& vertex) {
  const CellPlace at = place_of<S>(a, flat);
  return for_shape<S>(at, [&]<Shape Of>() {
    const Gathered<Of> cell(at);
    const cells::FilterResult result = cells::contain_filter<Of>(cell.x, p);
    if (result != cells::FilterResult::undecided)
      return result == cells::FilterResult::inside ? Proof::inside : Proof::outside;
    bool on_vertex = false;
#pragma unroll
    for (int v = Gathered<Of>::count - 1; v >= 0; --v)
      if (cell.x[v] == p) {
        on_vertex = true;
        vertex = v;
      }
    return on_vertex ? Proof::on_vertex : Proof::undecided;
  });
}

template <Shape S>
__device__ inline cells::InverseMap<double> invert(const Vec3d* x, const Vec3d& p) {
  if constexpr (S == Shape::tetrahedron)
    return cells::inverse_tetrahedron(x, p);
  else if constexpr (S == Shape::pyramid)
    return cells::inverse_pyramid(x, p);
  else if constexpr (S == Shape::wedge)
    return cells::inverse_wedge(x, p);
  else
    return cells::inverse_hexahedron(S, x, p);
}

__device__ inline double not_a_number() {
  return __longlong_as_double(0x7ff8000000000000ll);
}

__device__ inline void write_outside(const Outputs& out, std::uint32_t i) {
  if (out.cells)
    out.cells[i] = -1;
  if (out.reasons)
    out.reasons[i] = std::uint8_t(cells::Reason::outside);
  if (out.parametric)
    for (int a = 0; a < 3; ++a)
      out.parametric[3 * std::size_t(i) + a] = not_a_number();
  for (int f = 0; f < out.field_count; ++f) {
    const int n = out.fields[f].components;
    for (int c = 0; c < n; ++c)
      out.values[f][std::size_t(i) * n + c] = not_a_number();
  }
}

__device__ inline void write_owner(const Outputs& out, std::uint32_t i, std::uint32_t flat,
                                   cells::Reason reason) {
  if (out.cells)
    out.cells[i] = flat;
  if (out.reasons)
    out.reasons[i] = std::uint8_t(reason);
}

__device__ inline void write_cell_values(const Outputs& out, std::uint32_t i, const CellPlace& at) {
  for (int f = 0; f < out.field_count; ++f) {
    const DeviceField& field = out.fields[f];
    if (field.association != INSITU_CELL)
      continue;
    const mesh::FieldPieceView& from = field.pieces[at.number];
    for (int c = 0; c < field.components; ++c)
      out.values[f][std::size_t(i) * field.components + c] = from.load(at.cell, c);
  }
}

/// The sums are the CPU's (query::Sampler::interpolate), term by term.
template <Shape S>
__device__ inline void write_answer(const Outputs& out, std::uint32_t i, std::uint32_t flat,
                                    const CellPlace& at, const Gathered<S>& cell,
                                    cells::Reason reason, const Vec3d& r) {
  write_owner(out, i, flat, reason);
  if (out.parametric)
    for (int d = 0; d < 3; ++d)
      out.parametric[3 * std::size_t(i) + d] = r[d];
  if (out.field_count == 0)
    return;
  write_cell_values(out, i, at);
  double weight[8];
  cells::shape_functions(S, r, weight);
  for (int f = 0; f < out.field_count; ++f) {
    const DeviceField& field = out.fields[f];
    if (field.association == INSITU_CELL)
      continue;
    const mesh::FieldPieceView& from = field.pieces[at.number];
    for (int c = 0; c < field.components; ++c) {
      double sum = weight[0] * from.load(cell.ids[0], c);
#pragma unroll
      for (int v = 1; v < Gathered<S>::count; ++v)
        sum += weight[v] * from.load(cell.ids[v], c);
      out.values[f][std::size_t(i) * field.components + c] = sum;
    }
  }
}

/// The answer of a point whose owner is known.
template <bool map, Shape S>
__device__ inline void finish(const LocateArguments& a, std::uint32_t i, std::uint32_t flat,
                              const cells::Decision& decision, const Vec3d& p) {
  if (flat == none)
    return write_outside(a.out, i);
  if constexpr (!map) {
    write_owner(a.out, i, flat, decision.reason());
    if (a.out.field_count > 0)
      write_cell_values(a.out, i, place_of<S>(a, flat));
  } else {
    const CellPlace at = place_of<S>(a, flat);
    for_shape<S>(at, [&]<Shape Of>() {
      const Gathered<Of> cell(at);
      const auto found = invert<Of>(cell.x, p);
      if (cells::is_plausible(found.converged, found.margin))
        write_answer(a.out, i, flat, at, cell, decision.reason(),
                     cells::put_on(Of, decision,
                                   cells::put_on_nearest(Of, cell.x, p, found.r, found.error)));
      else
        a.lists.hard_points[atomicAdd(a.lists.counters + Lists::hard, 1u)] = {i, flat, decision};
    });
  }
}

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

} // namespace insitu::accel::cuda
