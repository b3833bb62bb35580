#pragma once

#include <cstdint>

#include "cells/kernels/cell_block.h"
#include "mesh/cell_arrays.h"

namespace insitu::cells {

/// Gathers cells of one shape into the columns of a block. Meshes of one piece with arrays of its
/// own, but for a first piece of gridlets, whose cells are not gathered, go through loops typed by
/// their numbers and layout, chosen once.
class CellGather {
public:
  /// Columns [0, n) from cells[0, n); cells[n, n + more) come next, and are asked for early.
  using Loop = void (*)(const mesh::CellArrays& arrays, const std::int64_t* cells, int n, int more,
                        CellBlock& block);

  /// alpha: coordinates between the earlier (0) and the current (1) step.
  CellGather(const mesh::MeshView& mesh, double alpha);

  /// All cells have one shape, so shape() need not be asked for each.
  bool one_shape() const { return one_shape_; }
  mesh::Shape shape(std::int64_t flat) const {
    if (one_shape_)
      return mesh_->pieces[0].uniform_shape;
    const std::int32_t p = only_ >= 0 ? only_ : mesh_->piece_of(flat);
    return mesh_->pieces[p].shape(flat - mesh_->first_cell[p]);
  }
  INSITU_PREFETCH void prefetch_ids(std::int64_t flat) const {
    if (arrays_.ids)
      __builtin_prefetch(arrays_.ids + flat * arrays_.cell_stride);
  }
  void fill(const std::int64_t* cells, int n, int more, CellBlock& block) const;

private:
  const mesh::MeshView* mesh_;
  double alpha_;
  bool one_shape_ = false;
  std::int32_t only_ = -1; ///< the only piece with cells to gather
  Loop loop_ = nullptr;
  mesh::CellArrays arrays_;
};

} // namespace insitu::cells
