#pragma once

#include <cstdint>
#include <span>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"
#include "query/seams.h"
#include "render/structures/chart_copies.h"

namespace insitu::render {

/// The cells around each vertex of a mesh, the owning ones and other processes' that lend their
/// values (mesh::is_duplicate; these may hold what is not finite), in ascending order: so sums over
/// them do not depend on threads. Vertices of different pieces that coincide are one
/// (mesh::join_pieces) where MeshView::join_pieces says so. On a chart a cell counts where the
/// solver has it, or else in its first copy over the seam, around all its vertices' copies; those
/// that hold a pole, which have no place there, do not. Within a piece ids tell, and in gridlets
/// vertices are those of one. Among cells of other processes the order is that of all cells, so
/// that sums do not depend on processes either. 8 bytes a vertex and 4 per corner of a cell; holds
/// as long as the cells do and, of several pieces, the coordinates.
class VertexCells {
public:
  /// seams: of a mesh with a halo; else null. copies: of a chart that has some; else null.
  VertexCells(const mesh::MeshView& mesh, const query::Seams* seams, const ChartCopies* copies,
              const core::Threads& threads, core::Memory& memory);

  /// Flat cells around a flat vertex.
  std::span<const std::uint32_t> of(std::int64_t vertex) const {
    const std::int64_t first = vertex == 0 ? 0 : end_[std::size_t(vertex) - 1];
    return {cells_.data() + first, std::size_t(end_[std::size_t(vertex)] - first)};
  }
  /// ChartCopies::turn, or 0.
  double turn() const { return turn_; }
  std::int64_t bytes() const { return std::int64_t(end_.bytes() + cells_.bytes()); }
  /// What bytes() will be; looks at the cells' shapes, no more.
  static std::int64_t bytes_for(const mesh::MeshView& mesh, const core::Threads& threads);

private:
  void join(const mesh::MeshView& mesh, const mesh::JoinedVertices& joined,
            const query::Seams* seams);

  core::Memory* memory_;
  double turn_ = 0;
  core::Buffer<std::int64_t> end_;    ///< of each vertex's list
  core::Buffer<std::uint32_t> cells_; ///< flat ids fit, as in the tree
};

} // namespace insitu::render
