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

/// The flat vertices of owning cells that lie in the closed box of another piece's owning cells,
/// ascending, if the boxes of both pieces are as said. Linear in the vertices.
std::vector<std::int64_t> vertices_in_other_boxes(const MeshView& mesh, Boxes boxes,
                                                  const core::Threads& threads);

/// Vertices of different pieces that coincide bit for bit (0 and -0 are one), in groups:
/// flat[end[g - 1], end[g]) ascends. Vertices of one piece are told apart by their ids, so a
/// piece that has several at a place, as at a crack, takes no part in that place's group.
struct JoinedVertices {
  std::vector<std::int64_t> flat, end;
};
JoinedVertices join_pieces(const MeshView& mesh, const core::Threads& threads);

} // namespace insitu::mesh
