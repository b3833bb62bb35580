#pragma once

#include "accel/locator.h"
#include "cells/kernels/on_feature.h"
#include "device/arithmetic.cuh"
#include "query/device/interpolate.cuh"
#include "query/device/locate_kernels.h"
#include "query/device/proof.cuh"

/// What locating kernels share: their points, and writing answers.
namespace insitu::query::on_device {

using accel::none;

INSITU_HD inline Vec3d point_of(const LocateArguments& a, std::uint32_t i) {
  const double* p = a.points + 3 * std::size_t(i);
  return {p[0], p[1], p[2]};
}

INSITU_HD inline void write_outside(const Outputs& out, std::uint32_t i) {
  if (out.cells)
    out.cells[i] = -1;
  if (out.reasons)
    out.reasons[i] = std::uint8_t(cells::Reason::outside);
  if (out.parametric)
    for (int a = 0; a < 3; ++a)
      out.parametric[3 * std::size_t(i) + a] = device::not_a_number();
  for (int f = 0; f < out.field_count; ++f) {
    const int n = out.fields[f].components;
    for (int c = 0; c < n; ++c)
      out.values[f][std::size_t(i) * n + c] = device::not_a_number();
  }
}

INSITU_HD inline void write_owner(const Outputs& out, std::uint32_t i, std::uint32_t flat,
                                  cells::Reason reason) {
  if (out.cells)
    out.cells[i] = flat;
  if (out.reasons)
    out.reasons[i] = std::uint8_t(reason);
}

INSITU_HD inline void write_cell_values(const Outputs& out, std::uint32_t i, const CellPlace& at) {
  for (int f = 0; f < out.field_count; ++f) {
    const KernelField& field = out.fields[f];
    if (field.association != INSITU_CELL)
      continue;
    const mesh::FieldPieceView& from = field.pieces[at.number];
    for (int c = 0; c < field.components; ++c)
      out.values[f][std::size_t(i) * field.components + c] = from.load(at.cell, c);
  }
}

template <Shape S>
INSITU_HD inline void write_answer(const Outputs& out, std::uint32_t i, std::uint32_t flat,
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
    const KernelField& field = out.fields[f];
    if (field.association == INSITU_CELL)
      continue;
    const mesh::FieldPieceView& from = field.pieces[at.number];
    for (int c = 0; c < field.components; ++c)
      out.values[f][std::size_t(i) * field.components + c] = interpolated(from, c, cell, weight);
  }
}

/// The answer of a point whose owner is known.
template <bool map, Shape S>
INSITU_HD inline void finish(const LocateArguments& a, std::uint32_t i, std::uint32_t flat,
                             const cells::Decision& decision, const Vec3d& p) {
  if (flat == none)
    return write_outside(a.out, i);
  if constexpr (!map) {
    write_owner(a.out, i, flat, decision.reason());
    if (a.out.field_count > 0)
      write_cell_values(a.out, i, place_of<S>(a.in.mesh, flat));
  } else {
    const CellPlace at = place_of<S>(a.in.mesh, flat);
    for_shape<S>(at, [&]<Shape Of>() {
      const Gathered<Of> cell(at);
      const auto found = invert<Of>(cell.x, p);
      if (cells::is_plausible(found.converged, found.margin))
        write_answer(a.out, i, flat, at, cell, decision.reason(),
                     cells::put_on(Of, decision,
                                   cells::put_on_nearest(Of, cell.x, p, found.r, found.error)));
      else
        a.lists.hard_points[device::add_to(a.lists.counters + Lists::hard, 1u)] = {i, flat,
                                                                                   decision};
    });
  }
}

} // namespace insitu::query::on_device
