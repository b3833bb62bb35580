#pragma once

#include <cstdint>
#include <span>

#include "mesh/view.h"
#include "query/gridlet_lanes.h"

namespace insitu::query {

/// Where the numbers at the vertices of gridlets' cells lie, in bytes from a component's first one;
/// stride: between vertices along i. Remembers the last gridlet.
class GridletStrides {
public:
  GridletStrides(const mesh::Gridlet* gridlets, std::int64_t stride)
      : gridlets_(gridlets), stride_(stride) {}

  /// Of the vertex at the lower corner of a cell; row() and layer() then are its gridlet's.
  std::int64_t lower(std::int64_t cell) {
    if (const std::int64_t gridlet = cell >> mesh::Gridlet::cell_bits; gridlet != last_)
      take(gridlet);
    return first_ + (cell & 7) * stride_ + ((cell >> 3) & 7) * row_ + ((cell >> 6) & 7) * layer_;
  }
  const mesh::Gridlet* gridlets() const { return gridlets_; }
  std::int64_t stride() const { return stride_; }
  std::int64_t row() const { return row_; }
  std::int64_t layer() const { return layer_; }

private:
  void take(std::int64_t gridlet) {
    const mesh::Gridlet& g = gridlets_[gridlet];
    last_ = gridlet;
    first_ = g.first * stride_;
    row_ = (g.size[0] + 1) * stride_;
    layer_ = (g.size[1] + 1) * row_;
  }

  const mesh::Gridlet* gridlets_;
  std::int64_t stride_, last_ = -1;
  std::int64_t first_ = 0, row_ = 0, layer_ = 0; ///< of the last gridlet
};

/// A vertex field's values in gridlets, of T.
template <class T>
class GridletValues {
public:
  GridletValues(const mesh::GridletsView& all, const mesh::FieldView& field)
      : component_(field.pieces[0].component), components_(field.components),
        strides_(all.gridlets, field.pieces[0].layout.stride[0]) {}

  /// A scalar field at the first locations, up to one that may lie in no gridlet; returns how many.
  std::size_t ahead(std::int64_t end, std::span<const Location> at, double* to) const {
    return components_ == 1 && strides_.stride() == sizeof(T)
               ? values_ahead(strides_.gridlets(), end, reinterpret_cast<const T*>(component_[0]),
                              at.data(), at.size(), to)
               : 0;
  }
  /// The field's components in a cell.
  void at(std::int64_t cell, const math::Vec3d& r, double* values) {
    const std::int64_t lower = strides_.lower(cell);
    const std::int64_t next = strides_.stride(), row = strides_.row(), layer = strides_.layer();
    const double i1 = r.x, i0 = 1.0 - i1, j1 = r.y, j0 = 1.0 - j1, k1 = r.z, k0 = 1.0 - k1;
    for (int c = 0; c < components_; ++c) {
      const std::byte* const v = component_[c] + lower;
      const auto along_i = [&](const std::byte* at) {
        return i0 * double(mesh::load_as<T>(at)) + i1 * double(mesh::load_as<T>(at + next));
      };
      values[c] = k0 * (j0 * along_i(v) + j1 * along_i(v + row)) +
                  k1 * (j0 * along_i(v + layer) + j1 * along_i(v + layer + row));
    }
  }

private:
  const std::byte* const* component_;
  int components_;
  GridletStrides strides_;
};

} // namespace insitu::query
