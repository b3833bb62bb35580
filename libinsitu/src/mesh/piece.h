#pragma once

#include <bit>
#include <concepts>
#include <cstdint>

#include "mesh/adaptive.h"
#include "mesh/array_view.h"
#include "mesh/gridlet.h"
#include "mesh/shape.h"

namespace insitu::mesh {

/// The four questions that a piece answers about its cells:
///
///   Shape shape(cell), int vertex_ids(cell, ids[8]), Vec3d point(id), bool owns(cell)
///
/// PieceView answers them for unstructured, implicit structured and adaptive pieces, and all of the
/// library takes PieceView. No kernel is a template over this concept: it lets a test hold
/// PieceView, and a stub of a polyhedral piece, against the four.
template <class C>
concept CellSource = requires(const C& c, std::int64_t cell, std::int64_t* ids) {
  { c.shape(cell) } -> std::same_as<Shape>;
  { c.vertex_ids(cell, ids) } -> std::same_as<int>;
  { c.point(cell) } -> std::same_as<math::Vec3d>;
  { c.owns(cell) } -> std::same_as<bool>;
};

enum class CellLayout : std::uint8_t { uniform, mixed, padded, block, gridlets, leaves };

struct PieceView;

/// What stands in for a piece whose cells are given by faces: cell c is the cells first[c] to
/// first[c + 1] - 1 of `piece`, whose vertices begin with the solver's.
struct PartsView {
  const PieceView* piece = nullptr;
  const std::uint32_t* first = nullptr;
};

/// A piece as kernels see it: plain data over the solver's arrays.
struct PieceView {
  // Cells.
  CellLayout layout = CellLayout::uniform;
  Shape uniform_shape = Shape::none; ///< of all cells but MIXED; PADDED: of 8 ids
  std::int64_t cell_count = 0;
  std::int64_t vertex_count = 0;
  IndexView connectivity;           ///< UNIFORM, PADDED: stride between cells
  std::int64_t id_stride = 0;       ///< bytes between the ids of a cell
  IndexView offsets;                ///< MIXED
  const std::byte* types = nullptr; ///< MIXED
  std::int64_t types_stride = 1;
  std::int64_t index_base = 0;
  // Implicit blocks: vertices along i, j, k.
  std::int64_t block_vertices[3] = {0, 0, 0};
  bool implicit_points = false; ///< uniform or rectilinear: coordinates from the axes
  double origin[3] = {0, 0, 0};
  double spacing[3] = {0, 0, 0};
  std::int64_t block_first[3] = {0, 0, 0}; ///< uniform: the first vertex's numbers from the origin
  const std::byte* axis[3] = {nullptr, nullptr, nullptr}; ///< rectilinear
  std::int64_t axis_stride[3] = {0, 0, 0};
  bool axis_is_float32 = false; ///< of a halo's piece: whether its vertices were where it is from
  // Gridlets of a dual mesh: cell c is cell c & 511 of gridlet c >> 9, a voxel if it owns points.
  const GridletsView* gridlets = nullptr;
  const LeavesView* leaves = nullptr; ///< cells of an adaptive mesh as they are: voxels
  /// Of cells given by faces, which have no shape here: UNIFORM, and no ids.
  const PartsView* parts = nullptr;
  /// Of what stands in for such cells (PartsView::piece): which of them a cell is a part of; the
  /// parts of one follow each other.
  const std::uint32_t* part_of = nullptr;
  // Geometry, ghosts.
  PointsView points;
  const std::byte* ghosts = nullptr;
  ItemLayout ghost_layout;
  std::uint8_t ghost_mask = 0; ///< bits that take a cell out
  bool is_halo = false;        ///< of cells that another process owns
  /// A bit a cell: another process owns it, though the piece is no halo; null: none.
  const std::uint64_t* foreign = nullptr;
  /// Of a flat mesh: so many vertices the solver has; `id` and `id + flat_vertices` are one of
  /// them, below and above the plane. 0: none.
  std::int64_t flat_vertices = 0;
  /// A geo::Pole: copies of a geodetic mesh's cells, on the chart turned to it; vectors too.
  std::int8_t pole = 0;

  INSITU_HD Shape shape(std::int64_t cell) const {
    if (layout != CellLayout::mixed && layout != CellLayout::padded)
      return uniform_shape;
    if (layout == CellLayout::mixed)
      return Shape(load_as<std::uint8_t>(types + cell * types_stride));
    int n = 0;
    while (n < 8 && from_base(padded_id(cell, n), index_base) >= 0)
      ++n;
    return padded_shape(n);
  }
  /// Of a PADDED cell of n ids.
  INSITU_HD Shape padded_shape(int n) const {
    return n == 8   ? uniform_shape
           : n == 6 ? Shape::wedge
           : n == 5 ? Shape::pyramid
           : n == 4 ? Shape::tetrahedron
                    : Shape::none;
  }

  /// The cell's vertex ids, 0-based, in VTK's order; returns how many.
  INSITU_HD int vertex_ids(std::int64_t cell, std::int64_t* ids) const {
    if (layout == CellLayout::block) {
      const std::int64_t ci = block_vertices[0] - 1, cj = block_vertices[1] - 1;
      const std::int64_t row = cell / ci;
      const std::int64_t i = cell - row * ci, j = row % cj, k = row / cj;
      const std::int64_t dj = block_vertices[0], dk = block_vertices[0] * block_vertices[1];
      const std::int64_t v = i + dj * j + dk * k;
      ids[0] = v;
      ids[1] = v + 1;
      ids[2] = v + 1 + dj;
      ids[3] = v + dj;
      ids[4] = v + dk;
      ids[5] = v + dk + 1;
      ids[6] = v + dk + 1 + dj;
      ids[7] = v + dk + dj;
      return 8;
    }
    if (layout == CellLayout::gridlets)
      return gridlets->vertex_ids(cell, ids);
    if (layout == CellLayout::leaves) {
      for (int v = 0; v < 8; ++v)
        ids[v] = 8 * cell + v;
      return 8;
    }
    const int n = vertex_count_of(shape(cell));
    const std::byte* base =
        layout == CellLayout::mixed
            ? connectivity.data + from_base(offsets.load(cell), index_base) * id_stride
            : connectivity.data + cell * connectivity.stride;
    for (int v = 0; v < n; ++v)
      ids[v] = from_base(load_index(base + v * id_stride, connectivity.is_int32), index_base);
    return n;
  }

  INSITU_HD math::Vec3d point(std::int64_t id) const {
    if (layout == CellLayout::gridlets)
      return gridlets->point(id);
    if (layout == CellLayout::leaves)
      return leaves->point(id);
    if (!implicit_points)
      return points.load(id);
    const std::int64_t row = id / block_vertices[0];
    const std::int64_t ijk[3] = {id - row * block_vertices[0], row % block_vertices[1],
                                 row / block_vertices[1]};
    math::Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = block_coordinate(a, ijk[a]);
    return p;
  }
  /// Of vertex i along an axis, of a block with implicit points.
  INSITU_HD double block_coordinate(int a, std::int64_t i) const {
    return axis[a] ? load_real(axis[a] + i * axis_stride[a], axis_is_float32)
                   : origin[a] + double(block_first[a] + i) * spacing[a];
  }

  /// Whether the cell may be the answer for a point, and counts in sums over cells: all that exist,
  /// but for those of a halo.
  INSITU_HD bool owns(std::int64_t cell) const { return is_own(cell) && exists(cell); }
  /// Whether it is this process's, if it exists.
  INSITU_HD bool is_own(std::int64_t cell) const {
    return !is_halo && !(foreign && (foreign[cell >> 6] >> (cell & 63) & 1));
  }
  /// Whether the cell is there: trees and tables of faces hold it, points are located in it,
  /// averages take its value. Ghost, blanked and empty cells are not: they may hold anything.
  INSITU_HD bool exists(std::int64_t cell) const {
    if (layout == CellLayout::gridlets)
      return gridlets->is_full(cell);
    if (layout == CellLayout::leaves)
      return leaves->is_leaf(cell);
    return !ghosts || (load_as<std::uint8_t>(ghosts + ghost_layout.offset(cell)) & ghost_mask) == 0;
  }

  /// The vertex as the solver counts.
  INSITU_HD std::int64_t solver_vertex(std::int64_t id) const {
    return flat_vertices > 0 && id >= flat_vertices ? id - flat_vertices : id;
  }

  /// False only if all cells exist.
  INSITU_HD bool may_not_exist() const {
    return ghosts || layout == CellLayout::gridlets || (leaves && leaves->masked);
  }

  // What trees hold are items: cells, or runs of cells (gridlets), which go by their first cell.

  /// Cells come in runs. A vertex is then found through its run: a cell's vertices come from
  /// cell_points(), and not one by one from their ids.
  INSITU_HD bool in_runs() const { return layout == CellLayout::gridlets; }
  INSITU_HD std::int64_t cells_an_item() const { return in_runs() ? Gridlet::most_cells : 1; }
  /// The cells of the item that begins at `cell` that exist: how many, and the first of them.
  struct ItemCells {
    std::int64_t count, first;
  };
  ItemCells item_cells(std::int64_t cell) const {
    if (!in_runs())
      return {exists(cell), cell};
    ItemCells found{0, cell};
    for (int word = Gridlet::side; word-- > 0;) // a bit a cell
      if (const std::uint64_t full = gridlets->full[(cell >> 6) + word])
        found = {found.count + std::popcount(full), cell + 64 * word + std::countr_zero(full)};
    return found;
  }
  /// visit(vertex) for all vertices of the item that `cell` begins, in a cell's order or ascending;
  /// of a cell given by faces more than once.
  template <class Visit>
  void for_each_item_vertex(std::int64_t cell, Visit&& visit) const {
    std::int64_t ids[8];
    if (parts) {
      for (std::int64_t part = parts->first[cell]; part < parts->first[cell + 1]; ++part) {
        const int n = parts->piece->vertex_ids(part, ids);
        for (int v = 0; v < n; ++v)
          if (ids[v] < vertex_count)
            visit(ids[v]);
      }
      return;
    }
    if (in_runs()) {
      const Gridlet& g = gridlets->gridlets[cell >> Gridlet::cell_bits];
      for (std::int64_t v = g.first, end = v + g.vertex_count(); v < end; ++v)
        visit(v);
      return;
    }
    const int n = vertex_ids(cell, ids);
    for (int v = 0; v < n; ++v)
      visit(ids[v]);
  }
  /// Neighbouring cells of the piece have the ids of their common vertices in common.
  INSITU_HD bool shares_vertices() const {
    return layout != CellLayout::gridlets && layout != CellLayout::leaves;
  }
  /// The coordinates of a cell's vertices: ids[count], as vertex_ids() tells them.
  INSITU_HD void cell_points(std::int64_t cell, const std::int64_t* ids, int count,
                             math::Vec3d* x) const {
    if (in_runs())
      return gridlets->points(cell, x);
    if (is_section()) { // the offset of a vertex takes divisions
      const std::int64_t first = points.layout.offset(ids[0]);
      for (int v = 0; v < 8; ++v)
        x[v] =
            points.at(first + ((v ^ v >> 1) & 1) * points.layout.stride[0] +
                      (v >> 1 & 1) * points.layout.stride[1] + (v >> 2) * points.layout.stride[2]);
      return;
    }
    for (int v = 0; v < count; ++v)
      x[v] = point(ids[v]);
  }
  /// Whether the vertices are those of a block whose coordinates are a section of larger arrays.
  INSITU_HD bool is_section() const {
    return !points.layout.linear && layout == CellLayout::block && !implicit_points &&
           points.layout.extent[0] == block_vertices[0] &&
           points.layout.extent[1] == block_vertices[1];
  }

  /// Id v of 8 in the padded layout, as the solver counts; -1 is padding.
  INSITU_HD std::int64_t padded_id(std::int64_t cell, int v) const {
    return load_index(connectivity.data + cell * connectivity.stride + v * id_stride,
                      connectivity.is_int32);
  }
  INSITU_HD static int vertex_count_of(Shape s) { return mesh::vertex_count(s); }
};

} // namespace insitu::mesh
