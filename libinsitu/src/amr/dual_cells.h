#pragma once

#include <cstdint>

#include "amr/neighborhood.h"
#include "math/vec.h"
#include "mesh/shape.h"

namespace insitu::amr {

/// A vertex of stitching cells: the centre of a leaf, moved along some axes to its lower or upper
/// face where the domain ends there. 27 `moves`: 0 none, 1 to the lower, 2 to the upper face along
/// x, plus 3 times that along y, plus 9 times that along z.
struct VertexKey {
  std::uint32_t leaf;
  std::uint32_t moves;
  bool operator==(const VertexKey&) const = default;
};

/// Of a leaf's vertex along an axis, in half cells of the leaf's depth: its place.
inline std::int64_t halves(std::int64_t cell_index, std::uint32_t moves, int axis) {
  constexpr std::uint32_t weight[3] = {1, 3, 9};
  const std::uint32_t move = moves / weight[axis] % 3;
  return 2 * cell_index + (move == 0 ? 1 : move == 1 ? 0 : 2);
}

/// A cell of the dual mesh that is no cube of a gridlet.
struct DualCell {
  VertexKey vertices[8]; ///< in VTK's order, the shape's count of them
  mesh::Shape shape;
  std::uint8_t distinct; ///< vertices; fewer than the shape's: collapsed
  bool boundary;
};

/// The dual cell of a corner: its vertices are the leaves' centres. Where octants lie outside and
/// the others form a box, those stand in that mirror them, moved to the domain's boundary. False
/// if they form no box.
bool dual_cell(const Corner& corner, DualCell& cell);

/// Whether the corner's cell folds or is turned inside out.
bool folds(const Corner& corner);

} // namespace insitu::amr
