#pragma once

#include <cmath>
#include <cstdint>

#include "cells/kernels/kernels.h"
#include "core/parallel.h"
#include "mesh/view.h"
#include "query/sampler.h"

namespace insitu::render {

/// The number that is drawn of a field: a component, or, for component -1, the magnitude (for a
/// field of one component, its value). A magnitude is taken at the vertices and interpolated from
/// there, so that it lies within the range of the vertices of its cell.
struct ScalarField {
  mesh::FieldView field;
  int component = -1;

  double load(std::int32_t piece, std::int64_t item) const {
    const mesh::FieldPieceView& from = field.pieces[piece];
    if (component >= 0)
      return from.load(item, component);
    if (field.components == 1)
      return from.load(item, 0);
    double sum = 0.0;
    for (int c = 0; c < field.components; ++c) {
      const double v = from.load(item, c);
      sum += v * v;
    }
    return std::sqrt(sum);
  }

  /// Prefetches an item that will be loaded.
  void prefetch(std::int32_t piece, std::int64_t item) const {
    const mesh::FieldPieceView& from = field.pieces[piece];
    if (from.layout.linear)
      __builtin_prefetch(from.component[component > 0 ? component : 0] +
                         item * from.layout.stride[0]);
  }

  /// Returns the value at a location, which must be inside.
  double at(const mesh::MeshView& mesh, const query::Location& location) const {
    const std::int32_t piece = mesh.piece_of(location.cell);
    const std::int64_t cell = location.cell - mesh.first_cell[piece];
    if (field.association == INSITU_CELL)
      return load(piece, cell);
    const mesh::PieceView& cells_of = mesh.pieces[piece];
    std::int64_t ids[8];
    double weight[8] = {}, number[8];
    const int n = cells_of.vertex_ids(cell, ids);
    cells::shape_functions(cells_of.shape(cell), location.parametric, weight);
    for (int v = 0; v < n; ++v)
      number[v] = load(piece, ids[v]);
    return cells::weighted_mean(n, weight, number);
  }
};

/// The least and the greatest finite value in owning cells or at their vertices; low > high if
/// there is no finite value.
struct ScalarRange {
  double low = HUGE_VAL, high = -HUGE_VAL;
};
ScalarRange scalar_range(const mesh::MeshView& mesh, const ScalarField& scalar,
                         const core::Threads& threads);

/// Returns the component by which ValueRanges has the same number: the magnitude that it takes of a
/// field of one component would be |value|.
inline int range_component(const ScalarField& f) {
  return f.component < 0 && f.field.components == 1 ? 0 : f.component;
}

} // namespace insitu::render
