#pragma once

#include <cstdint>

#include "cells/kernels/kernels.h"
#include "mesh/view.h"

namespace insitu::query {

/// A vertex field's values, of T, in the stitching cells of an adaptive mesh's dual.
template <class T>
class StitchingValues {
public:
  /// piece: the stitching cells'.
  StitchingValues(const mesh::MeshView& dual, const mesh::FieldView& field, std::int32_t piece)
      : cells_(dual.pieces[piece]), from_(field.pieces[piece]), components_(field.components) {}

  // Asked for ahead: first what tells a cell's vertices, then what tells the values there.
  void ask_for_ids(std::int64_t cell) const { __builtin_prefetch(ids_of(cell)); }
  void ask_for_values(std::int64_t cell) const {
    const std::int32_t* const ids = ids_of(cell);
    for (int v = 0, n = count(ids); v < n; ++v)
      __builtin_prefetch(from_.component[0] + ids[v] * from_.layout.stride[0]);
  }

  /// The field's components in a cell.
  void at(std::int64_t cell, const math::Vec3d& r, double* values) const {
    const std::int32_t* const ids = ids_of(cell);
    const int n = count(ids);
    double weight[8];
    cells::shape_functions(cells_.padded_shape(n), r, weight);
    for (int c = 0; c < components_; ++c) {
      const auto value = [&](int v) {
        return double(mesh::load_as<T>(from_.component[c] + ids[v] * from_.layout.stride[0]));
      };
      double sum = weight[0] * value(0);
      for (int v = 1; v < n; ++v)
        sum += weight[v] * value(v);
      values[c] = sum;
    }
  }

private:
  const std::int32_t* ids_of(std::int64_t cell) const {
    return reinterpret_cast<const std::int32_t*>(cells_.connectivity.data) + 8 * cell;
  }
  /// Of vertices; padding is below zero.
  static int count(const std::int32_t* ids) {
    return ids[7] >= 0 ? 8 : ids[5] >= 0 ? 6 : ids[4] >= 0 ? 5 : 4;
  }

  const mesh::PieceView& cells_;
  const mesh::FieldPieceView& from_;
  int components_;
};

} // namespace insitu::query
