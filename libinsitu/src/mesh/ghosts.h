#pragma once

#include <cstdint>

#include "mesh/piece.h"

namespace insitu::mesh {

/// A ghost cell that is nothing but another process's cell: VTK's bit 1 without those that blank a
/// cell, Ascent's 1. Its values are real where the solver keeps its ghosts up to date; its ids may
/// still be garbage.
inline bool is_duplicate(const PieceView& piece, std::int64_t cell) {
  return piece.ghosts && (load_as<std::uint8_t>(piece.ghosts + piece.ghost_layout.offset(cell)) &
                          piece.ghost_mask) == 1;
}

/// Gives a view ghosts in the place of the solver's: a byte a cell, of which any of these bits
/// takes a cell out. They must outlive the view.
inline void set_ghosts(PieceView& piece, const std::uint8_t* of_cells, std::uint8_t bits) {
  piece.ghosts = reinterpret_cast<const std::byte*>(of_cells);
  piece.ghost_layout = {piece.cell_count, {piece.cell_count, 1}, {1, 0, 0}, true};
  piece.ghost_mask = bits;
}

/// For cells that validation leaves out: whether shape() and vertex_ids() can be asked, and give a
/// shape and ids of vertices that there are.
inline bool has_sound_ids(const PieceView& piece, std::int64_t cell) {
  if (piece.layout == CellLayout::mixed) {
    const int type = load_as<std::uint8_t>(piece.types + cell * piece.types_stride);
    if (!is_shape(type))
      return false;
    const std::int64_t start = from_base(piece.offsets.load(cell), piece.index_base);
    if (start < 0 || start > piece.connectivity.count - vertex_count(Shape(type)))
      return false;
  }
  std::int64_t ids[8];
  const int n = piece.vertex_ids(cell, ids);
  for (int v = 0; v < n; ++v)
    if (ids[v] < 0 || ids[v] >= piece.vertex_count)
      return false;
  return n > 0;
}

} // namespace insitu::mesh
