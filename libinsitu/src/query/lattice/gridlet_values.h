#pragma once

#include <cstdint>
#include <span>

#include "mesh/view.h"
#include "query/lattice/gridlet_lanes.h"
#include "query/lattice/gridlet_strides.h"

namespace insitu::query {

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
