#pragma once

#include <cstdint>
#include <limits>

#include "accel/rays/ray_rules.h"
#include "cells/kernels.h"
#include "mesh/view.h"

/// What `fast` answers once a ray has told the cell: for every home, as ray_rules.h is.
namespace insitu::accel {

// insitu_reason.
constexpr std::uint8_t outside_reason = 0, certified_reason = 1;

INSITU_HD inline double not_a_number() {
  return std::numeric_limits<double>::quiet_NaN();
}

/// Whether floats can trace the ray; NaN, infinite and distant points have none.
INSITU_HD inline bool can_start(const PointRay& ray) {
  const math::Vec3f& o = ray.origin;
  return std::fabs(o.x) < 1e37f && std::fabs(o.y) < 1e37f && std::fabs(o.z) < 1e37f;
}

/// Point in cell by Newton in double. A point on a face is in either cell, whichever is asked
/// first.
INSITU_HD inline bool holds(const cells::InverseMap<double>& map) {
  return map.converged && map.margin >= -1e-9;
}

/// The coordinates that `fast` tells, of a cell that by its planes holds the point: where Newton
/// does not end, what it left is drawn to the cell.
INSITU_HD inline math::Vec3d parametric_of(const cells::InverseMap<double>& map) {
  if (map.converged)
    return map.r;
  math::Vec3d r;
  for (int a = 0; a < 3; ++a)
    r[a] = map.r[a] > 0.0 ? (map.r[a] < 1.0 ? map.r[a] : 1.0) : 0.0;
  return r;
}

/// Item `item` of arrays [count][components], one a field. Field: mesh::FieldView, or a device's.
template <class Field>
INSITU_HD inline void write_fields(const mesh::CellVertices& x, const mesh::MeshView& mesh,
                                   std::int64_t flat, const math::Vec3d& r, const Field* fields,
                                   int field_count, double* const* values, std::size_t item) {
  double weights[8];
  if (field_count > 0)
    cells::shape_functions(x.shape, r, weights);
  for (int f = 0; f < field_count; ++f) {
    const mesh::FieldPieceView& piece = fields[f].pieces[x.piece];
    double* out = values[f] + item * std::size_t(fields[f].components);
    for (int c = 0; c < fields[f].components; ++c) {
      if (fields[f].association == INSITU_CELL) {
        out[c] = piece.load(flat - mesh.first_cell[x.piece], c);
        continue;
      }
      double sum = 0.0;
      for (int v = 0; v < x.count; ++v)
        sum += weights[v] * piece.load(x.ids[v], c);
      out[c] = sum;
    }
  }
}

/// The same of cell fields alone, for which no vertex is read.
template <class Field>
INSITU_HD inline void write_cell_fields(const mesh::MeshView& mesh, std::int64_t flat,
                                        const Field* fields, int field_count, double* const* values,
                                        std::size_t item) {
  const int p = mesh.piece_count == 1 ? 0 : mesh.piece_of(flat);
  for (int f = 0; f < field_count; ++f)
    for (int c = 0; c < fields[f].components; ++c)
      values[f][item * std::size_t(fields[f].components) + c] =
          fields[f].pieces[p].load(flat - mesh.first_cell[p], c);
}

template <class Field>
INSITU_HD inline void write_no_fields(const Field* fields, int field_count, double* const* values,
                                      std::size_t item) {
  for (int f = 0; f < field_count; ++f)
    for (int c = 0; c < fields[f].components; ++c)
      values[f][item * std::size_t(fields[f].components) + c] = not_a_number();
}

} // namespace insitu::accel
