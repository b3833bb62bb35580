#pragma once

#include <vector>

#include "accel/node.h"
#include "mesh/view.h"

namespace insitu::accel {

/// Computes cell boxes in a local frame, outwards. The choice among number types and array layouts
/// is made once a piece, at construction; points that have no arrays of their own, or whose blocks
/// are not evenly spaced, take the general way.
class CellBoxes {
public:
  CellBoxes(const mesh::MeshView& mesh, const math::Vec3d& origin);

  /// The boxes of n flat cells. Returns the lowest of the cells with a coordinate that is not
  /// finite or too large for a float (its box is empty), or -1.
  std::int64_t compute(const std::uint32_t* flat_cells, std::uint32_t n, Box* boxes) const;

  /// What the loops over a piece need.
  struct Arrays {
    std::int64_t first = 0; ///< flat id of the piece's first cell
    const std::byte* ids = nullptr;
    std::int64_t cell_stride = 0, id_stride = 0, base = 0;
    const std::byte* types = nullptr;   ///< mixed
    const std::byte* offsets = nullptr; ///< mixed
    std::int64_t types_stride = 0, offset_stride = 0;
    bool offset_is_int32 = false;
    std::uint32_t block_cells[2] = {1, 1};    ///< blocks: along i, j
    std::int64_t block_stride[3] = {0, 0, 0}; ///< blocks: bytes between vertices along i, j, k
    const std::byte* component[3] = {};
    std::int64_t point_stride = 0;
    math::Vec3d origin;
    const mesh::MeshView* mesh = nullptr; ///< for the general way
  };
  using Loop = std::int64_t (*)(const Arrays&, const std::uint32_t*, std::uint32_t, Box*);

private:
  struct Piece {
    Arrays arrays;
    Loop loop;
  };
  static Piece choose(const mesh::MeshView& mesh, std::int32_t piece, const math::Vec3d& origin);

  const mesh::MeshView* mesh_;
  std::vector<Piece> pieces_;
};

} // namespace insitu::accel
