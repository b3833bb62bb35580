#pragma once

#include "accel/cuda/locate_kernels.h"
#include "accel/locator.h"
#include "cells/contain_filter.h"
#include "cells/kernels.h"

/// What locating kernels share: gathering a cell, proofs, writing answers.
namespace insitu::accel::cuda {

using math::Vec3d;
using mesh::Shape;

__device__ inline Vec3d point_of(const LocateArguments& a, std::uint32_t i) {
  const double* p = a.points + 3 * std::size_t(i);
  return {p[0], p[1], p[2]};
}

/// S: the only shape of the only piece, whose view lies among the kernel's arguments; or none.
template <Shape S>
__device__ inline void gather_cell(const LocateArguments& a, std::uint32_t flat,
                                   mesh::CellVertices& out) {
  if constexpr (S == Shape::none) {
    mesh::gather(a.mesh, flat, out);
  } else {
    constexpr int n = mesh::vertex_count(S);
    const mesh::PieceView& piece = a.piece;
    out.shape = S;
    out.count = n;
    out.piece = 0;
    if (S == Shape::hexahedron && piece.layout == mesh::CellLayout::block) {
      piece.vertex_ids(flat, out.ids);
    } else {
      const std::byte* base = piece.connectivity.data + flat * piece.connectivity.stride;
#pragma unroll
      for (int v = 0; v < n; ++v)
        out.ids[v] = mesh::from_base(
            mesh::load_index(base + v * piece.id_stride, piece.connectivity.is_int32),
            piece.index_base);
    }
#pragma unroll
    for (int v = 0; v < n; ++v)
      out.x[v] = piece.point(out.ids[v]);
  }
}

template <Shape S>
__device__ inline cells::FilterResult prove(const mesh::CellVertices& cell, const Vec3d& p) {
  if constexpr (S != Shape::none) {
    return cells::contain_filter<S>(cell.x, p);
  } else {
    switch (cell.shape) {
    case Shape::tetrahedron:
      return cells::contain_filter<Shape::tetrahedron>(cell.x, p);
    case Shape::voxel:
      return cells::contain_filter<Shape::voxel>(cell.x, p);
    case Shape::hexahedron:
      return cells::contain_filter<Shape::hexahedron>(cell.x, p);
    case Shape::wedge:
      return cells::contain_filter<Shape::wedge>(cell.x, p);
    case Shape::pyramid:
      return cells::contain_filter<Shape::pyramid>(cell.x, p);
    default:
      return cells::FilterResult::outside;
    }
  }
}

template <Shape S>
__device__ inline cells::InverseMap<double> invert(const mesh::CellVertices& cell, const Vec3d& p) {
  if constexpr (S == Shape::tetrahedron)
    return cells::inverse_tetrahedron(cell.x, p);
  else if constexpr (S == Shape::hexahedron)
    return cells::inverse_hexahedron(S, cell.x, p);
  else
    return cells::inverse_map(cell.shape, cell.x, p);
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

/// r: looked at if out.needs_map. The sums are the CPU's (query::Sampler::interpolate), term by
/// term.
__device__ inline void write_answer(const LocateArguments& a, std::uint32_t i, std::uint32_t flat,
                                    const mesh::CellVertices& cell, cells::Reason reason,
                                    const Vec3d& r) {
  const Outputs& out = a.out;
  if (out.cells)
    out.cells[i] = flat;
  if (out.reasons)
    out.reasons[i] = std::uint8_t(reason);
  if (out.parametric)
    for (int d = 0; d < 3; ++d)
      out.parametric[3 * std::size_t(i) + d] = r[d];
  if (out.field_count == 0)
    return;
  double weight[8];
  if (out.needs_map)
    cells::shape_functions(cell.shape, r, weight);
  for (int f = 0; f < out.field_count; ++f) {
    const DeviceField& field = out.fields[f];
    const mesh::FieldPieceView& from = field.pieces[cell.piece];
    double* values = out.values[f] + std::size_t(i) * field.components;
    for (int c = 0; c < field.components; ++c) {
      if (field.association == INSITU_CELL) {
        values[c] = from.load(flat - (cell.piece ? a.mesh.first_cell[cell.piece] : 0), c);
        continue;
      }
      double sum = weight[0] * from.load(cell.ids[0], c);
#pragma unroll
      for (int v = 1; v < 8; ++v)
        if (v < cell.count)
          sum += weight[v] * from.load(cell.ids[v], c);
      values[c] = sum;
    }
  }
}

/// The answer of a point whose owner is known.
template <bool map, Shape S>
__device__ inline void finish(const LocateArguments& a, std::uint32_t i, std::uint32_t flat,
                              cells::Reason reason, const Vec3d& p) {
  if (flat == none)
    return write_outside(a.out, i);
  mesh::CellVertices cell;
  Vec3d r{};
  if constexpr (map) {
    gather_cell<S>(a, flat, cell);
    const auto found = invert<S>(cell, p);
    if (!cells::is_plausible(found.converged, found.margin)) {
      a.lists.hard_points[atomicAdd(a.lists.counters + Lists::hard, 1u)] = {i, flat, reason};
      return;
    }
    r = found.r;
  } else {
    cell.piece = a.out.field_count > 0 && a.mesh.piece_count > 1 ? a.mesh.piece_of(flat) : 0;
  }
  write_answer(a, i, flat, cell, reason, r);
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
