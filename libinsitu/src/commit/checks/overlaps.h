#pragma once

#include <cstdint>
#include <optional>

#include "accel/faces/mesh_faces.h"
#include "accel/tree/tree.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::commit {

/// Whether a search finds no two cells that share interior (MeshView::covers_once): one piece, free
/// of folds, neighbours on either side of every face that they share, and no vertex of a boundary
/// face in or on a cell that does not have it. Vertices are told apart by ids, so parts that touch
/// without sharing vertices are taken to overlap. Not found: boundaries that cross with no vertex
/// of either inside the other. faces, tree: of this mesh. Costs locating the boundary's vertices.
bool covers_once(const mesh::MeshView& mesh, const accel::MeshFaces& faces, const accel::Tree& tree,
                 const core::Threads& threads);

/// What a search for cells of two pieces that share interior finds.
struct PiecesApart {
  /// How deep a vertex lies in another piece's cell, in the cell's own units, for the two to be
  /// told: where pieces meet in a curved face and their vertices do not match, cells overlap by
  /// less.
  static constexpr double depth = 0.05;
  struct Overlap {
    std::int64_t cell, other; ///< flat ids, of two pieces, ascending
  };

  /// No middle of an owning cell is in or on another piece's cell, and no vertex in or on one that
  /// has no vertex of the same coordinates.
  bool apart = false;
  /// Of two cells that share volume the first that are found, the same for any thread count: a
  /// cell with its middle in the other, else a cell with a vertex so deep in the other.
  std::optional<Overlap> overlap;
};

/// Pieces whose boxes share no interior need no search. Not found: pieces that cross with no vertex
/// of either inside the other. tree: of this mesh.
PiecesApart look_at_pieces(const mesh::MeshView& mesh, const accel::Tree& tree,
                           const core::Threads& threads);

} // namespace insitu::commit
