#pragma once

#include <cstdint>

#include "mesh/gridlet.h"

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

} // namespace insitu::query
