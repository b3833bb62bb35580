#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::mesh {

/// The piece of a flat vertex.
inline std::int32_t piece_of_vertex(const MeshView& mesh, std::int64_t flat) {
  const std::int64_t* const first = mesh.first_vertex;
  return std::int32_t(std::upper_bound(first, first + mesh.piece_count, flat) - first) - 1;
}

/// Which boxes of two pieces have to do with each other.
enum class Boxes { touch, share_interior };

/// What of a piece lies in the closed boxes of other pieces' owning cells, both ascending.
struct AmongOthers {
  std::vector<std::int64_t> vertices; ///< flat ids of owning cells' vertices
  std::vector<std::int64_t> cells;    ///< flat ids of owning cells whose middle lies there
};
/// Of all pieces; counts boxes as said. Cells are looked for if they are asked for. Linear in the
/// vertices (and cells) of pieces whose boxes meet.
AmongOthers find_among_others(const MeshView& mesh, Boxes boxes, bool with_cells,
                              const core::Threads& threads);
/// The mean of a cell's vertices.
math::Vec3d middle_of(const CellVertices& cell);

/// Vertices of different pieces that coincide bit for bit (0 and -0 are one), in groups:
/// flat[end[g - 1], end[g]) ascends. Vertices of one piece are told apart by their ids, so a
/// piece that has several at a place, as at a crack, takes no part in that place's group.
struct JoinedVertices {
  std::vector<std::int64_t> flat, end;
};
JoinedVertices join_pieces(const MeshView& mesh, const core::Threads& threads);

} // namespace insitu::mesh
