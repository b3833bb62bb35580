#pragma once

#include <cstdint>

#include "amr/leaves/neighborhood.h"
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

/// Whether a vertex is moved along an axis: 0 no, 1 to the lower, 2 to the upper face.
inline std::uint32_t move_along(std::uint32_t moves, int axis) {
  constexpr std::uint32_t weight[3] = {1, 3, 9};
  return moves / weight[axis] % 3;
}

/// Of a leaf's vertex along an axis, in half cells of the leaf's depth: its place.
inline std::int64_t halves(std::int64_t cell_index, std::uint32_t moves, int axis) {
  const std::uint32_t move = move_along(moves, axis);
  return 2 * cell_index + (move == 0 ? 1 : move == 1 ? 0 : 2);
}

/// A cell of the dual mesh that is no cube of a gridlet.
struct DualCell {
  std::uint32_t leaves[8]; ///< of the vertices, in VTK's order, the shape's count of them
  std::uint8_t moves[8];   ///< of the vertices
  mesh::Shape shape;
  std::uint8_t distinct; ///< vertices; fewer than the shape's: collapsed
  bool boundary;         ///< by the domain's boundary: only then are vertices moved or means

  VertexKey vertex(int v) const { return {leaves[v], moves[v]}; }
  void set_vertex(int v, const VertexKey& key) {
    leaves[v] = key.leaf;
    moves[v] = std::uint8_t(key.moves);
  }
};

/// Whether a cell folds or is turned inside out.
bool folds(mesh::Shape shape, const math::Vec3d* x);

/// Makes the dual cells of corners; remembers the shapes of the last ones, of which there are few
/// kinds. Large: not for the stack.
class DualCells {
public:
  /// This thread's: what they remember holds for all meshes.
  static DualCells& of_thread();

  /// The dual cell of a corner: its vertices are the leaves' centres. Where octants lie outside and
  /// the others form a box, those stand in that mirror them, moved to the domain's boundary. False
  /// if they form no box.
  bool make(const Corner& corner, DualCell& cell);

  /// Whether the cell of the last corner that one was made for folds or is turned inside out.
  bool folds();

private:
  /// What a hexahedron is when octants share a leaf.
  struct Collapsed {
    mesh::Shape shape;
    std::uint8_t distinct;   ///< vertices
    std::uint8_t octants[8]; ///< in the order of the shape's vertices
  };
  enum class Folds : std::uint8_t { unknown, no, yes };
  struct Known {
    std::uint64_t pattern = 0; ///< all that shape and folds depend on; 0: none
    Collapsed shape;
    Folds folds;
  };
  static Collapsed collapse(const VertexKey* keys);
  bool look_for_folds() const;

  const Corner* corner_ = nullptr;
  VertexKey keys_[8];
  int source_[8];
  Known other_; ///< a pattern that is not kept
  Known* last_ = nullptr;
  static constexpr int known_bits = 14;
  Known known_[1 << known_bits];
};

} // namespace insitu::amr
