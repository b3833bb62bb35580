#pragma once

#include <vector>

#include "accel/tree/node.h"
#include "mesh/cell_arrays.h"

namespace insitu::accel {

/// Computes boxes of cells, and of gridlets by their first cells, in a local frame, outwards. The
/// choice among number types and array layouts is made once a piece, at construction; points that
/// have no arrays of their own, or whose blocks are not evenly spaced, take the general way.
class CellBoxes {
public:
  CellBoxes(const mesh::MeshView& mesh, const math::Vec3d& origin);

  /// The boxes of n flat cells; `more` behind them come next, and are asked for early. Returns the
  /// lowest of the cells with a coordinate that is not finite or too large for a float (its box is
  /// empty), or -1.
  std::int64_t compute(const std::uint32_t* flat_cells, std::uint32_t n, std::uint32_t more,
                       Box* boxes) const;

  struct Piece;
  using Loop = std::int64_t (*)(const Piece&, const std::uint32_t* cells, std::uint32_t n,
                                std::uint32_t more, Box*);
  /// What the loops over a piece need.
  struct Piece {
    mesh::CellArrays arrays;
    std::int64_t first = 0; ///< flat id of its first cell
    math::Vec3d origin;
    const mesh::MeshView* mesh = nullptr; ///< for the general way
    std::int32_t index = 0;               ///< of the piece in it
    Loop loop = nullptr;
  };

private:
  const mesh::MeshView* mesh_;
  std::vector<Piece> pieces_;
};

} // namespace insitu::accel
