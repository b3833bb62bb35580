#pragma once

#include <vector>

#include "amr/dual/dual_cells.h"
#include "mesh/lattice.h"

namespace insitu::amr {

/// A vertex that is no leaf's: its value is the mean of some leaves' (virtual ones, too), or, in a
/// line with leaves' vertices, of the values there (vertex_values.h).
struct MeanVertex {
  math::Vec3d x;
  std::uint32_t leaves[8];
  std::uint8_t moves[8]; ///< see VertexKey; of those in a line
  std::uint8_t count;
  bool on_line;
};

/// VertexKey::moves of a MeanVertex; the key's leaf is its number.
constexpr std::uint32_t mean_moves = 27;

/// The dual cells of a corner where the domain is re-entrant: octants lie inside and outside, and
/// those inside form no box. They are star-shaped from the corner; so there is a vertex in it, and
/// over each of the six faces of the octants' hexahedron, or what of it lies inside, a pyramid. A
/// face that is re-entrant itself is shared with the next such corner; it has a vertex where the
/// domain's edge crosses it, and triangles around that, under tetrahedra. All other faces are those
/// of the neighbours' cells; but where the domain ends in the middle of a leaf's face, without a
/// leaf of that depth beside it, a plane quad of the leaf's own value may meet two triangles. Adds
/// cells and vertices; returns whether one of the cells folds.
bool split_reentrant(const Corner& corner, const mesh::Lattice& lattice,
                     std::vector<DualCell>& cells, std::vector<MeanVertex>& means);

} // namespace insitu::amr
