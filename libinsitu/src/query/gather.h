#pragma once

#include <cstdint>

#include "mesh/view.h"
#include "query/pairs.h"

namespace insitu::query {

/// Gathers cells of one shape into the columns of a block. The most frequent meshes (one piece, one
/// shape, evenly spaced arrays) go through loops typed by their numbers, chosen once.
class CellGather {
public:
  /// Such a mesh's arrays: id v of a cell at ids + cell * cell_stride + v * id_stride, coordinate a
  /// of a vertex at component[a] + id * point_stride.
  struct Arrays {
    const std::byte* ids = nullptr;
    std::int64_t cell_stride = 0, id_stride = 0, base = 0;
    const std::byte* component[3] = {};
    std::int64_t point_stride = 0;
    std::int64_t last = -1; ///< the last vertex, behind whose z there may be nothing to read
    double padded[4] = {};  ///< its coordinates
  };
  /// Columns [0, n) from cells[0, n); cells[n, n + more) come next, and are asked for early.
  using Loop = void (*)(const Arrays& arrays, const std::int64_t* cells, int n, int more,
                        PairBlock& block);

  /// alpha: coordinates between the earlier (0) and the current (1) step.
  CellGather(const mesh::MeshView& mesh, double alpha);

  /// All cells have one shape, so shape() need not be asked for each.
  bool one_shape() const { return loop_ != nullptr; }
  mesh::Shape shape(std::int64_t flat) const {
    if (loop_)
      return mesh_->pieces[0].uniform_shape;
    const std::int32_t p = mesh_->piece_count == 1 ? 0 : mesh_->piece_of(flat);
    return mesh_->pieces[p].shape(flat - mesh_->first_cell[p]);
  }
  void prefetch_ids(std::int64_t flat) const {
    if (loop_)
      __builtin_prefetch(arrays_.ids + flat * arrays_.cell_stride);
  }
  void fill(const std::int64_t* cells, int n, int more, PairBlock& block) const;

private:
  const mesh::MeshView* mesh_;
  double alpha_;
  Loop loop_ = nullptr;
  Arrays arrays_;
};

} // namespace insitu::query
