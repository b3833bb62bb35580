#pragma once

#include <algorithm>
#include <cstdint>

#include "mesh/array_view.h"
#include "mesh/lattice.h"

namespace insitu::mesh {

/// A piece of an adaptive mesh, as the solver stores it: a patch of cells of one level, or leaves
/// of octrees. Plain data over the solver's arrays.
struct AmrPieceView {
  bool is_patch = true;
  std::int64_t cell_count = 0;
  // A patch: the cells [lower, lower + size) of one depth, i fastest.
  int depth = 0;
  std::int64_t lower[3] = {0, 0, 0};
  std::int64_t size[3] = {0, 0, 0};
  std::uint8_t ghost_faces = 0; ///< a bit a face, 2 axis + side: its fields hold ghost cells there
  // Leaves: a level each, and the index of the lower corner.
  const std::byte* levels = nullptr; ///< int8 (uint8), int32 or int64
  std::int64_t levels_stride = 0;
  int level_bytes = 4;
  const std::byte* corner[3] = {nullptr, nullptr, nullptr};
  std::int64_t corner_stride = 0;
  bool corner_is_int32 = true;
  int corner_depth = -1;              ///< the lattice that corners count in; -1: the leaf's own
  std::int64_t offset[3] = {0, 0, 0}; ///< added to corners, counted as they are
  // Leaves kept as records: the arrays hold pointers, and what they mean lies so many bytes behind.
  bool levels_indirect = false, corner_indirect = false;
  std::int64_t levels_behind = 0, corner_behind[3] = {0, 0, 0};
  // Leaves of another process: their levels are depths, and behind their values come those of their
  // ghost cells.
  std::int32_t rank = -1;                    ///< whose they are; -1: the solver's here
  std::int32_t number = 0;                   ///< of the piece there
  const std::int32_t* ghost_items = nullptr; ///< [cell][face]: the ghost's item; -1: none

  /// Whether a cell of the patch lies at that face of it.
  bool is_at_face(const struct AmrCell& cell, int face) const;

  INSITU_HD std::int64_t raw_level(std::int64_t cell) const {
    const std::byte* p = levels + cell * levels_stride;
    if (levels_indirect)
      p = load_as<const std::byte*>(p) + levels_behind;
    return level_bytes == 1 ? std::int64_t(load_as<std::int8_t>(p))
                            : load_index(p, level_bytes == 4);
  }
  INSITU_HD std::int64_t raw_corner(std::int64_t cell, int axis) const {
    if (!corner[axis]) // the third one of a flat mesh
      return 0;
    const std::byte* p = corner[axis] + cell * corner_stride;
    if (corner_indirect)
      p = load_as<const std::byte*>(p) + corner_behind[axis];
    return load_index(p, corner_is_int32);
  }
};

/// A cell's place: its depth and its index on the depth's lattice.
struct AmrCell {
  int depth = 0;
  std::int64_t index[3] = {0, 0, 0};
};

inline bool AmrPieceView::is_at_face(const AmrCell& cell, int face) const {
  const int a = face >> 1;
  return cell.index[a] == (face & 1 ? lower[a] + size[a] - 1 : lower[a]);
}

/// All pieces of an adaptive mesh, checked apart from each other: indices are in range, but patches
/// may lie on or under others. Cells are numbered flat over the pieces. Valid until the next update
/// of the registrations.
struct AmrView {
  static constexpr int most_levels = Lattice::most_depth + 1;
  Lattice lattice;
  int level_count = 1;
  bool finest_first = false;               ///< leaves' raw levels count from the finest
  std::int8_t depth_of[most_levels] = {0}; ///< of level l, 0 the coarsest
  const AmrPieceView* pieces = nullptr;
  const std::int64_t* first_cell = nullptr; ///< [piece_count + 1]
  std::int32_t piece_count = 0;
  /// So many of these, the last ones, are other processes' leaves. Those that do not touch leaves
  /// here come last: they give values, and no corner that none but they have is this process's.
  std::int32_t halo_piece_count = 0, far_piece_count = 0;
  /// Whether other processes may have more of the mesh, not known here, that covers its cells.
  bool is_part = false;
  /// A bit a cell of this process: finer cells cover it, maybe of other processes; null: not known.
  const std::uint64_t* covered = nullptr;

  INSITU_HD std::int64_t cell_count() const { return first_cell[piece_count]; }
  std::int64_t own_cell_count() const { return first_cell[piece_count - halo_piece_count]; }
  /// Of this process and of those that touch them, whose ids come first.
  std::int64_t near_cell_count() const { return first_cell[piece_count - far_piece_count]; }
  bool is_covered(std::int64_t flat) const {
    return covered && flat < own_cell_count() && (covered[flat >> 6] >> (flat & 63) & 1) != 0;
  }
  int finest_depth() const { return depth_of[level_count - 1]; }
  bool has_ghosts() const {
    return std::any_of(pieces, pieces + piece_count,
                       [](const AmrPieceView& p) { return p.ghost_faces != 0 || p.ghost_items; });
  }

  /// Where a cell of a piece lies.
  INSITU_HD AmrCell cell(const AmrPieceView& piece, std::int64_t cell) const {
    AmrCell c;
    if (piece.is_patch) {
      c.depth = piece.depth;
      const std::int64_t row = cell / piece.size[0];
      c.index[0] = piece.lower[0] + cell - row * piece.size[0];
      c.index[1] = piece.lower[1] + row % piece.size[1];
      c.index[2] = piece.lower[2] + row / piece.size[1];
      return c;
    }
    const std::int64_t raw = piece.raw_level(cell);
    c.depth = piece.rank >= 0 ? int(raw) : depth_of[finest_first ? level_count - 1 - raw : raw];
    const int shift = piece.corner_depth < 0 ? 0 : piece.corner_depth - c.depth;
    for (int a = 0; a < 3; ++a)
      c.index[a] = (piece.raw_corner(cell, a) + piece.offset[a]) >> shift;
    return c;
  }
};

/// A piece's cells as voxels, for `nearest` reconstruction. Vertex v of cell c has the id 8 c + v.
struct LeavesView {
  const AmrView* mesh = nullptr;
  std::int32_t piece = 0;
  const std::uint64_t* masked = nullptr; ///< a bit a flat cell: under finer cells; null: none

  INSITU_HD bool is_leaf(std::int64_t cell) const {
    const std::int64_t flat = mesh->first_cell[piece] + cell;
    return !masked || !((masked[flat >> 6] >> (flat & 63)) & 1);
  }
  INSITU_HD math::Vec3d point(std::int64_t vertex) const {
    const AmrCell c = mesh->cell(mesh->pieces[piece], vertex >> 3);
    math::Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = mesh->lattice.place(a, c.depth, 2 * (c.index[a] + ((vertex >> a) & 1)));
    return p;
  }
};

} // namespace insitu::mesh
