#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mesh/piece.h"

namespace insitu::mesh {

/// A field on one piece. Component c of item i lies at component[c] + layout.offset(i), or, where
/// `behind` is given, behind[c] bytes behind the pointer that lies there.
struct FieldPieceView {
  const std::byte* const* component = nullptr;
  ItemLayout layout;
  bool is_float32 = false;
  const std::int64_t* behind = nullptr; ///< null: values lie in place, not behind pointers;
                                        ///< otherwise layout is not linear

  INSITU_HD double load(std::int64_t item, int c) const {
    return load_real(layout.linear ? component[c] + item * layout.stride[0] : far_item(item, c),
                     is_float32);
  }
  /// Loads the ghost cell across a face (2 axis + side) from an item at that face, in a patch whose
  /// fields hold ghost cells (AmrPieceView).
  double load_ghost(std::int64_t item, int c, int face) const {
    const std::int64_t step = layout.stride[face >> 1];
    return load_real(component[c] + layout.offset(item) + (face & 1 ? step : -step), is_float32);
  }
  INSITU_HD const std::byte* far_item(std::int64_t item, int c) const {
    return behind ? load_as<const std::byte*>(component[c] + item * layout.stride[0]) + behind[c]
                  : component[c] + layout.offset(item);
  }
};

/// A field over all pieces of a mesh. It is plain data, valid until the next commit.
struct FieldView {
  const char* name = "";
  insitu_association association = INSITU_VERTEX;
  int components = 0;
  const FieldPieceView* pieces = nullptr;
  /// Whether items may have no value, which then is NaN: tracers take the cells of such items as
  /// walls, and averages leave the items out.
  bool has_blanks = false;
};

/// All pieces of a committed mesh as kernels see them, as plain data that is valid until the next
/// commit. Flat ids number the cells of all pieces: flat = first_cell[piece] + cell. Vertices are
/// numbered likewise.
struct MeshView {
  const PieceView* pieces = nullptr;
  const std::int64_t* first_cell = nullptr;   ///< [piece_count + 1]
  const std::int64_t* first_vertex = nullptr; ///< [piece_count + 1]
  std::int32_t piece_count = 0;
  /// So many of these, the last ones, are a halo: cells of other processes that touch this one's.
  std::int32_t halo_piece_count = 0;
  /// Coordinates of the vertices at the earlier step, by flat id, which the mesh keeps for
  /// pathlines only; null: none are kept.
  const math::Vec3d* earlier_points = nullptr;
  /// The largest distance of a vertex from its earlier place along any axis.
  double largest_displacement = 0.0;
  /// Whether a mesh of several pieces is as good as one piece. It is so where no cells of two
  /// pieces share interior as far as a search tells (commit/checks/overlaps.h), and where the
  /// pieces behind the first hold copies of its cells, in the places of cells that the first piece
  /// hides or far from all other cells.
  bool one_mesh = false;
  /// Whether vertices of different pieces that coincide bit for bit are one vertex for averages and
  /// normals.
  bool join_pieces = false;
  /// Whether no cell folds or is inverted. A cell that holds a point strictly inside then answers
  /// alone, but in `exact` only with covers_once.
  bool free_of_folds = false;
  /// Whether no two cells share interior as far as a search tells (commit/checks/overlaps.h). With
  /// free_of_folds, a cell that holds a point strictly inside then answers alone in `exact` as
  /// well.
  bool covers_once = false;
  /// Whether the cells are flat ones, given a thickness (FlatPiece). Points then lie in `plane`,
  /// their third coordinate, and vectors have two components.
  bool is_flat = false;
  double plane = 0.0;
  /// Of cells on the lattices of an adaptive mesh.
  void set_plane(const Lattice& lattice) {
    is_flat = lattice.is_flat != 0;
    plane = lattice.plane;
  }

  /// Whether a field's values are vectors, which turn with the axes: those of three components, and
  /// of a flat mesh those of two.
  INSITU_HD bool is_vector(const FieldView& field) const {
    return field.components == 3 || (is_flat && field.components == 2);
  }
  INSITU_HD std::int64_t cell_count() const { return first_cell[piece_count]; }
  /// Those of this process, whose flat ids come first.
  INSITU_HD std::int64_t own_cell_count() const {
    return first_cell[piece_count - halo_piece_count];
  }
  /// Whether a cell that exists is this process's.
  INSITU_HD bool is_own(std::int64_t flat_cell) const {
    const std::int32_t piece = piece_of(flat_cell);
    return pieces[piece].is_own(flat_cell - first_cell[piece]);
  }
  INSITU_HD std::int64_t vertex_count() const { return first_vertex[piece_count]; }

  /// Cells below this flat id come in runs (PieceView::in_runs): those of the first piece, or none.
  INSITU_HD std::int64_t first_single_cell() const {
    return piece_count > 0 && pieces[0].in_runs() ? first_cell[1] : 0;
  }

  /// Returns the piece that holds the cell of a flat id.
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

/// The gathered vertices of one cell.
struct CellVertices {
  Shape shape = Shape::none;
  int count = 0;
  std::int32_t piece = 0;
  std::int64_t ids[8]; ///< ids within the piece
  math::Vec3d x[8];
};

/// Gathers the coordinates of the vertices in out.ids, which are those of the cell of the piece.
INSITU_HD inline void gather_points(const PieceView& piece, std::int64_t cell, CellVertices& out) {
  piece.cell_points(cell, out.ids, out.count, out.x);
}

/// Gathers a cell of a mesh. alpha blends the earlier (0) and the current (1) coordinates; it must
/// be 1 if the mesh keeps no earlier points.
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
