#pragma once

#include <vector>

#include "amr/dual_cells.h"
#include "amr/enumerate.h"
#include "mesh/piece.h"

namespace insitu::amr {

/// Leaves that only the dual mesh has: numbered from `first` on, with their places.
struct VirtualLeaves {
  std::int64_t first = 0;
  std::vector<mesh::AmrCell> cells;
  std::vector<std::uint32_t> parents; ///< the real leaf that each lies in
};

/// Stitching cells as a PADDED piece: int32 ids, -1 for padding, and the vertices' points and
/// leaves. Vertices are numbered in the order of their leaves, those of virtual leaves last.
class Stitching {
public:
  explicit Stitching(core::Memory& memory);
  void build(const std::vector<DualPart>& parts, const mesh::AmrView& mesh,
             const VirtualLeaves& virtual_leaves, const core::Threads& threads);
  void clear();

  std::int64_t cell_count() const { return std::int64_t(ids_.size() / 8); }
  std::int64_t vertex_count() const { return std::int64_t(leaves_.size()); }
  std::int64_t bytes() const {
    return std::int64_t(ids_.bytes() + points_.bytes() + leaves_.bytes());
  }
  mesh::PieceView piece() const;
  /// A vertex's leaf.
  const std::uint32_t* leaves() const { return leaves_.data(); }

private:
  core::Buffer<std::int32_t> ids_;
  core::Buffer<double> points_;
  core::Buffer<std::uint32_t> leaves_;
};

} // namespace insitu::amr
