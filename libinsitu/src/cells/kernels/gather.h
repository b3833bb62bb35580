#pragma once

#include <cstdint>

#include "cells/kernels/cell_block.h"
#include "mesh/cell_arrays.h"

namespace insitu::cells {

/// Gathers cells of one shape into the columns of a block. Cells of a mesh's largest piece, if it
/// has arrays of its own, go through a loop typed by their numbers and layout, chosen once; other
/// pieces are mostly few cells of other processes. A first piece of gridlets, whose cells are not
/// gathered, does not count.
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
    if (arrays_.ids && only_ >= 0)
      __builtin_prefetch(arrays_.ids + flat * arrays_.cell_stride);
  }
  void fill(const std::int64_t* cells, int n, int more, CellBlock& block) const;

private:
  void choose(std::int32_t piece);
  bool in_loop(std::int64_t cell) const { return cell >= first_ && cell < end_; }

  const mesh::MeshView* mesh_;
  double alpha_;
  bool one_shape_ = false;
  std::int32_t only_ = -1; ///< the only piece with cells to gather
  Loop loop_ = nullptr;
  std::int64_t first_ = 0, end_ = 0; ///< flat cells that it takes
  mesh::CellArrays arrays_;
};

} // namespace insitu::cells
