#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mesh/piece.h"

namespace insitu::mesh {

/// A field on one piece: component c of item i lies at component[c] + layout.offset(i), or
/// behind[c] bytes behind the pointer there.
struct FieldPieceView {
  const std::byte* const* component = nullptr;
  ItemLayout layout;
  bool is_float32 = false;
  const std::int64_t* behind = nullptr; ///< null: no pointers; otherwise layout is not linear

  INSITU_HD double load(std::int64_t item, int c) const {
    return load_real(layout.linear ? component[c] + item * layout.stride[0] : far_item(item, c),
                     is_float32);
  }
  /// Of a patch whose fields hold ghost cells (AmrPieceView): that across a face, 2 axis + side, of
  /// an item at the face.
  double load_ghost(std::int64_t item, int c, int face) const {
    const std::int64_t step = layout.stride[face >> 1];
    return load_real(component[c] + layout.offset(item) + (face & 1 ? step : -step), is_float32);
  }
  INSITU_HD const std::byte* far_item(std::int64_t item, int c) const {
    return behind ? load_as<const std::byte*>(component[c] + item * layout.stride[0]) + behind[c]
                  : component[c] + layout.offset(item);
  }
};

/// A field over all pieces of a mesh; plain data, valid until the next commit.
struct FieldView {
  const char* name = "";
  insitu_association association = INSITU_VERTEX;
  int components = 0;
  const FieldPieceView* pieces = nullptr;
  /// Items may have no value, which then is NaN: tracers take their cells as walls, and averages
  /// leave them out.
  bool has_blanks = false;
};

/// All pieces of a committed mesh as kernels see them; plain data, valid until the next commit.
/// Cells are numbered flat over the pieces: flat = first_cell[piece] + cell; so are vertices.
struct MeshView {
  const PieceView* pieces = nullptr;
  const std::int64_t* first_cell = nullptr;   ///< [piece_count + 1]
  const std::int64_t* first_vertex = nullptr; ///< [piece_count + 1]
  std::int32_t piece_count = 0;
  /// The vertices' coordinates at the earlier step, flat, or null (kept for pathlines only).
  const math::Vec3d* earlier_points = nullptr;
  /// How far a vertex is from its earlier place, at most, along any axis.
  double largest_displacement = 0.0;
  /// Of several pieces: the mesh is as good as one piece, since no two pieces' cells share interior
  /// as far as a search tells (commit/checks/overlaps.h), or since the pieces behind the first are
  /// copies of its cells where these are hidden, or far from all others.
  bool one_mesh = false;
  /// Vertices of different pieces that coincide bit for bit are one for averages and normals.
  bool join_pieces = false;
  /// No cell folds or is inverted, so a cell that holds a point strictly inside is its only owner.
  bool free_of_folds = false;
  /// As far as a search for overlaps tells (query/), no two cells share interior: with
  /// free_of_folds, a cell that holds a point strictly inside answers alone in `exact` as well.
  bool covers_once = false;

  INSITU_HD std::int64_t cell_count() const { return first_cell[piece_count]; }
  INSITU_HD std::int64_t vertex_count() const { return first_vertex[piece_count]; }

  /// Cells below this flat id come in runs (PieceView::in_runs): those of the first piece, or none.
  INSITU_HD std::int64_t first_single_cell() const {
    return piece_count > 0 && pieces[0].in_runs() ? first_cell[1] : 0;
  }

  /// The piece that holds a flat cell id.
  INSITU_HD std::int32_t piece_of(std::int64_t flat_cell) const {
    std::int32_t lo = 0, hi = piece_count - 1;
    while (lo < hi) {
      const std::int32_t mid = (lo + hi + 1) / 2;
      if (first_cell[mid] <= flat_cell)
        lo = mid;
      else
        hi = mid - 1;
    }
    return lo;
  }
};

/// The vertices of one cell, gathered.
struct CellVertices {
  Shape shape = Shape::none;
  int count = 0;
  std::int32_t piece = 0;
  std::int64_t ids[8]; ///< within the piece
  math::Vec3d x[8];
};

/// The coordinates of the vertices in out.ids, those of the piece's cell.
INSITU_HD inline void gather_points(const PieceView& piece, std::int64_t cell, CellVertices& out) {
  piece.cell_points(cell, out.ids, out.count, out.x);
}

/// Gathers a cell. alpha blends the earlier (0) and the current (1) coordinates; it must be 1 if
/// the mesh keeps no earlier points.
INSITU_HD inline void gather(const MeshView& mesh, std::int64_t flat_cell, CellVertices& out,
                             double alpha = 1.0) {
  out.piece = mesh.piece_of(flat_cell);
  const PieceView& piece = mesh.pieces[out.piece];
  const std::int64_t cell = flat_cell - mesh.first_cell[out.piece];
  out.shape = piece.shape(cell);
  out.count = piece.vertex_ids(cell, out.ids);
  gather_points(piece, cell, out);
  if (alpha != 1.0) {
    const math::Vec3d* earlier = mesh.earlier_points + mesh.first_vertex[out.piece];
    for (int v = 0; v < out.count; ++v)
      out.x[v] = (1.0 - alpha) * earlier[out.ids[v]] + alpha * out.x[v];
  }
}

} // namespace insitu::mesh
