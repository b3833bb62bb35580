#pragma once

#include <vector>

#include "amr/dual/dual_cells.h"
#include "amr/dual/enumerate.h"
#include "amr/dual/virtual_leaves.h"
#include "mesh/piece.h"

namespace insitu::amr {

/// Stitching cells as a PADDED piece: int32 ids, -1 for padding, and the vertices' points and
/// leaves. Vertices are numbered in the order of their leaves, those of virtual leaves and means
/// last.
class Stitching {
public:
  explicit Stitching(core::Memory& memory);
  void build(const std::vector<DualPart>& parts, const mesh::AmrView& mesh,
             const VirtualLeaves& virtual_leaves, bool with_corners, const core::Threads& threads);
  void clear();

  std::int64_t cell_count() const { return std::int64_t(ids_.size() / 8); }
  std::int64_t vertex_count() const { return std::int64_t(leaves_.size()); }
  std::int64_t bytes() const {
    return std::int64_t(ids_.bytes() + points_.bytes() + leaves_.bytes()) + corners_.bytes();
  }
  mesh::PieceView piece() const;
  /// Which of the cells stand at corners; empty if built without.
  const CornerMap& corners() const { return corners_; }
  CornerMap& corners() { return corners_; }
  /// Of the cells; empty if nobody asked for them.
  std::span<const CellPlace> places() const { return places_; }
  /// The vertices in re-entrant corners; of the last build.
  std::span<const MeanVertex> means() const { return means_; }
  /// The vertices on the domain's boundary that ghost cells give a value; of the last build, which
  /// keeps them no longer.
  std::vector<VertexKey> take_on_boundary() { return std::move(on_boundary_); }
  /// A vertex's leaf; means, and after them vertices on the boundary that ghost cells give a value,
  /// are numbered like further virtual leaves.
  const std::uint32_t* leaves() const { return leaves_.data(); }

private:
  core::Buffer<std::int32_t> ids_;
  core::Buffer<double> points_;
  core::Buffer<std::uint32_t> leaves_;
  CornerMap corners_;
  void number_on_boundary(const std::vector<std::uint8_t>& moves, std::int64_t first);

  std::vector<MeanVertex> means_;
  std::vector<VertexKey> on_boundary_;
  std::vector<CellPlace> places_;
};

} // namespace insitu::amr
