#pragma once

#include <cstdint>

#include "accel/locator.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::accel {

/// The cells across each cell's faces, by flat ids: a row of 4 bytes a face for each cell, counted
/// as INSITU_MEMORY_NEIGHBOURS. Cells that do not share the vertices of a face by their ids, as
/// those of different pieces, are no neighbours here.
class FaceNeighbours {
public:
  explicit FaceNeighbours(core::Memory& memory);

  /// Whether there can be a table: cells and vertices of vertex ids, fewer than 2^32 - 1 of either.
  static bool fits(const mesh::MeshView& mesh);
  /// The bytes of its table; reads the shapes where a piece mixes them.
  static std::int64_t bytes(const mesh::MeshView& mesh, const core::Threads& threads);

  /// Of a mesh that fits. The same for any thread count; meanwhile it takes 12 bytes more a face.
  /// Of three cells or more with the same face only the first two are neighbours.
  void build(const mesh::MeshView& mesh, const core::Threads& threads);

  /// Across a face of its shape (cells::face_table); -1 where there is none.
  std::int64_t across(std::int64_t cell, int face) const {
    const std::uint32_t other = cells_[std::size_t(cell * faces_ + face)];
    return other == none ? -1 : std::int64_t(other);
  }
  /// Asks for a cell's row.
  void foresee(std::int64_t cell) const { __builtin_prefetch(&cells_[std::size_t(cell * faces_)]); }

private:
  core::Memory* memory_;
  core::Buffer<std::uint32_t> cells_; ///< [cell][face], `none` where there is none
  std::int64_t faces_ = 0;            ///< of a row: the most that a cell has
};

} // namespace insitu::accel
