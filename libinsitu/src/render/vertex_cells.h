#pragma once

#include <cstdint>
#include <span>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::render {

/// The owning cells around each vertex of a piece, in ascending order: so sums over them do not
/// depend on threads. 8 bytes a vertex and 4 per corner of a cell.
class VertexCells {
public:
  VertexCells(const mesh::MeshView& mesh, std::int32_t piece, const core::Threads& threads,
              core::Memory& memory);

  /// Of a vertex of the piece; numbered within the piece.
  std::span<const std::uint32_t> of(std::int64_t vertex) const {
    const std::int64_t first = vertex == 0 ? 0 : end_[std::size_t(vertex) - 1];
    return {cells_.data() + first, std::size_t(end_[std::size_t(vertex)] - first)};
  }

private:
  core::Buffer<std::int64_t> end_;    ///< of each vertex's list
  core::Buffer<std::uint32_t> cells_; ///< flat ids fit, as in the tree
};

} // namespace insitu::render
