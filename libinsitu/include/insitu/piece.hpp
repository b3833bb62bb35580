/** @file piece.hpp
 *  One piece of a mesh, for insitu.hpp, which includes this file. */
#ifndef INSITU_PIECE_HPP
#define INSITU_PIECE_HPP

#include <algorithm>
#include <memory>

#include "insitu/array.hpp"
#include "insitu/types.hpp"

namespace insitu {

namespace detail {

inline void check(insitu_status status) {
  if (status != INSITU_OK)
    throw Error(status, insitu_last_message());
}

/** What the wrapper knows of a mesh: the counts that pointers alone do not carry. All Mesh objects
 *  of one mesh share it. */
struct MeshState {
  struct Counts {
    std::int64_t vertices = -1, cells = -1;
  };
  insitu_mesh handle = nullptr;
  std::vector<Counts> pieces;

  Counts& counts(int piece) {
    const auto p = static_cast<std::size_t>(piece < 0 ? 0 : piece);
    if (p >= pieces.size())
      pieces.resize(p + 1);
    return pieces[p];
  }
};

} // namespace detail

/** One piece of a mesh: vertices, cells, fields, ghosts. A later call replaces what an earlier one
 *  gave. All arrays are external; Array says how long the library reads them. Points and cells come
 *  before fields and ghosts, since bare pointers take their counts from them. Ghosts stay when
 *  cells are given again. A function that fails throws Error, and nothing has changed. */
class Piece {
public:
  /** Gives n vertices as x, y, z: float or double, one unit of length for all. */
  template <class T, class N, class = std::enable_if_t<detail::is_real<T> && std::is_integral_v<N>>>
  void points(const T* x, const T* y, const T* z, N n) {
    points(Array(x, n), Array(y, n), Array(z, n));
  }
  /** Gives n interleaved vertices: [n][3]. */
  template <class T, class N, class = std::enable_if_t<detail::is_real<T> && std::is_integral_v<N>>>
  void points(const T* xyz, N n) {
    points(Array(xyz, n).components(3));
  }
  /** Gives n vertices of a flat mesh as x, y. */
  template <class T, class N, class = std::enable_if_t<detail::is_real<T> && std::is_integral_v<N>>>
  void points(const T* x, const T* y, N n) {
    points(Array(x, n), Array(y, n));
  }
  /** Gives vertices of a flat mesh: two arrays of equal type, count and strides, or one of
   *  components(2). */
  void points(const Array& x, const Array& y) { give_points({x, y}, 1); }
  void flat_points(const Array& xy) { give_points({xy}, 2); }
  /** Gives vertices in containers or layouts of any stride; the three arrays have equal type, count
   *  and strides. */
  void points(const Array& x, const Array& y, const Array& z) { give_points({x, y, z}, 1); }
  /** Gives interleaved vertices; components(3) is understood. */
  void points(const Array& xyz) { give_points({xyz}, 3); }

  /** Gives cells of one shape: connectivity is [count][vertex_count(shape)] of int32 or int64, in
   *  VTK's order, whose ids begin with index_base (0 or 1). */
  template <class I, class N,
            class = std::enable_if_t<detail::is_index<I> && std::is_integral_v<N>>>
  void cells(Shape shape, const I* connectivity, N count, int index_base = 0) {
    cells(shape, Array(connectivity, count).components(vertex_count(shape)), index_base);
  }
  /** Gives cells of one shape from a container, whose size gives the number of cells, or in any
   *  stride. */
  void cells(Shape shape, Array connectivity, int index_base = 0) {
    give_cells(INSITU_LAYOUT_UNIFORM, shape, vertex_count(shape), connectivity, index_base);
  }
  /** hexahedra() and the five functions below are cells() with the shape in the name:
   *  (connectivity, count, index_base = 0) with a pointer, (connectivity, index_base = 0) with a
   *  container or an Array. */
  template <class C, class... Rest>
  void hexahedra(C&& connectivity, Rest... rest) {
    cells(Shape::hexahedron, std::forward<C>(connectivity), rest...);
  }
  template <class C, class... Rest>
  void tetrahedra(C&& connectivity, Rest... rest) {
    cells(Shape::tetrahedron, std::forward<C>(connectivity), rest...);
  }
  template <class C, class... Rest>
  void wedges(C&& connectivity, Rest... rest) {
    cells(Shape::wedge, std::forward<C>(connectivity), rest...);
  }
  template <class C, class... Rest>
  void pyramids(C&& connectivity, Rest... rest) {
    cells(Shape::pyramid, std::forward<C>(connectivity), rest...);
  }

  /** Cells of a flat mesh, in one plane. */
  template <class C, class... Rest>
  void triangles(C&& connectivity, Rest... rest) {
    cells(Shape::triangle, std::forward<C>(connectivity), rest...);
  }
  template <class C, class... Rest>
  void quads(C&& connectivity, Rest... rest) {
    cells(Shape::quad, std::forward<C>(connectivity), rest...);
  }

  /** Gives cells of several shapes. types: one uint8 a cell, VTK's numbers. offsets: the place in
   *  connectivity where a cell's ids start, one a cell or one more. offsets and connectivity are
   *  int32 or int64, and count from index_base. All three are containers, or Arrays with a
   *  count. */
  void mixed_cells(const Array& types, const Array& offsets, const Array& connectivity,
                   int index_base = 0) {
    insitu_cells c = insitu_cells_default();
    c.layout = INSITU_LAYOUT_MIXED;
    c.types = types.get(-1, "types");
    c.offsets = offsets.get(-1, "offsets");
    c.connectivity = connectivity.get(-1, "connectivity");
    c.count = c.types.count;
    c.index_base = index_base;
    give(c);
  }
  /** Gives cells of several shapes as [count][8] ids, in which unused ids are -1; the shape follows
   *  from the number of ids: 4, 5, 6 or 8. */
  template <class I, class N,
            class = std::enable_if_t<detail::is_index<I> && std::is_integral_v<N>>>
  void padded_cells(const I* connectivity, N count, int index_base = 0) {
    padded_cells(Array(connectivity, count).components(8), index_base);
  }
  void padded_cells(Array connectivity, int index_base = 0) {
    give_cells(INSITU_LAYOUT_PADDED, Shape::hexahedron, 8, connectivity, index_base);
  }

  /** Gives the cells of a flat mesh as [count][4] ids: quads, or triangles with -1 at the end. */
  void padded_flat_cells(Array connectivity, int index_base = 0) {
    give_cells(INSITU_LAYOUT_PADDED, Shape::quad, 4, connectivity, index_base);
  }

  /** Gives cells by their faces (insitu_faces), each of which names its one or two cells.
   *  vertices: the ids of the faces' vertices, face after face. offsets: one a face and one more,
   *  the places in vertices where faces start. owner: one cell a face. neighbour: the other cell of
   *  the first faces. All four hold int32 or int64, count from index_base, and are containers, or
   *  Arrays with a count. */
  void faces(const Array& vertices, const Array& offsets, const Array& owner,
             const Array& neighbour, std::int64_t cell_count, int index_base = 0) {
    insitu_faces f = faces_of(vertices, offsets, index_base);
    f.cell_count = cell_count;
    f.owner = owner.get(-1, "owner");
    f.neighbour = neighbour.get(-1, "neighbour");
    faces(f);
  }
  /** Gives cells by lists of their faces: cell_offsets, one a cell and one more, are the places in
   *  cell_faces where cells start. The rest is as above. */
  void faces_of_cells(const Array& vertices, const Array& offsets, const Array& cell_faces,
                      const Array& cell_offsets, int index_base = 0) {
    insitu_faces f = faces_of(vertices, offsets, index_base);
    f.form = INSITU_FACES_CELLS;
    f.cell_faces = cell_faces.get(-1, "cell_faces");
    f.cell_offsets = cell_offsets.get(-1, "cell_offsets");
    f.cell_count = std::max<std::int64_t>(f.cell_offsets.count - 1, 0);
    faces(f);
  }
  /** Gives cells by faces in any way that insitu_faces has. */
  void faces(const insitu_faces& faces) {
    detail::check(insitu_mesh_faces(handle(), index_, &faces));
    state_->counts(index_).cells = faces.cell_count;
  }

  /** Makes the piece a curvilinear block of ni x nj x nk vertices (below 2 along an axis it has no
   *  cells), whose points points() gives. Vertex (i, j, k) has the id i + ni*(j + nj*k), cell
   *  (i, j, k) the id i + (ni-1)*(j + (nj-1)*k); the arrays' strides say how the block lies in
   *  memory. */
  void block(std::int64_t ni, std::int64_t nj, std::int64_t nk) {
    insitu_block b = insitu_block_default();
    set_extent(b, ni, nj, nk);
    give(b);
  }
  /** Makes the piece a block with evenly spaced vertices; it needs no points(). first: the numbers
   * of its first vertex, counted from the origin. */
  void uniform_block(const std::array<std::int64_t, 3>& vertices,
                     const std::array<double, 3>& origin, const std::array<double, 3>& spacing,
                     const std::array<std::int64_t, 3>& first = {0, 0, 0}) {
    insitu_block b = insitu_block_default();
    b.kind = INSITU_BLOCK_UNIFORM;
    set_extent(b, vertices[0], vertices[1], vertices[2]);
    for (std::size_t a = 0; a < 3; ++a) {
      b.origin[a] = origin[a];
      b.spacing[a] = spacing[a];
      b.first[a] = first[a];
    }
    give(b);
  }
  /** Makes the piece a block with one array of coordinates an axis, containers or Arrays with a
   *  count; it needs no points(). */
  void rectilinear_block(const Array& x, const Array& y, const Array& z) {
    insitu_block b = insitu_block_default();
    b.kind = INSITU_BLOCK_RECTILINEAR;
    b.coordinates[0] = x.get(-1, "coordinates x");
    b.coordinates[1] = y.get(-1, "coordinates y");
    b.coordinates[2] = z.get(-1, "coordinates z");
    set_extent(b, b.coordinates[0].count, b.coordinates[1].count, b.coordinates[2].count);
    give(b);
  }

  /** The three blocks of a flat mesh: curvilinear, whose points points() or flat_points() gives,
   *  uniform, and rectilinear. Vertex (i, j) has the id i + ni*j, cell (i, j) the id
   *  i + (ni-1)*j. */
  void flat_block(std::int64_t ni, std::int64_t nj) { give(flat(ni, nj)); }
  void flat_uniform_block(const std::array<std::int64_t, 2>& vertices,
                          const std::array<double, 2>& origin, const std::array<double, 2>& spacing,
                          const std::array<std::int64_t, 2>& first = {0, 0}) {
    insitu_block b = flat(vertices[0], vertices[1]);
    b.kind = INSITU_BLOCK_UNIFORM;
    for (std::size_t a = 0; a < 2; ++a) {
      b.origin[a] = origin[a];
      b.spacing[a] = spacing[a];
      b.first[a] = first[a];
    }
    give(b);
  }
  void flat_rectilinear_block(const Array& x, const Array& y) {
    const insitu_array xs = x.get(-1, "coordinates x"), ys = y.get(-1, "coordinates y");
    insitu_block b = flat(xs.count, ys.count);
    b.kind = INSITU_BLOCK_RECTILINEAR;
    b.coordinates[0] = xs;
    b.coordinates[1] = ys;
    give(b);
  }

  /** Makes the piece a patch of an adaptive mesh (see Mesh::adaptive) with the cells from lower to
   *  lower + cells - 1 of a level; cell (i, j, k) of the patch has the id
   *  i + cells[0]*(j + cells[1]*k). ghosts: layers that the arrays of its fields hold around these
   *  cells, for samples beside the boundary (insitu_patch). */
  void patch(int level, const std::array<std::int64_t, 3>& lower,
             const std::array<std::int64_t, 3>& cells, const PatchGhosts& ghosts = {}) {
    insitu_patch p = insitu_patch_default();
    p.level = level;
    std::copy(lower.begin(), lower.end(), p.lower);
    std::copy(cells.begin(), cells.end(), p.cells);
    std::copy(ghosts.before.begin(), ghosts.before.end(), p.ghosts_before);
    std::copy(ghosts.after.begin(), ghosts.after.end(), p.ghosts_after);
    detail::check(insitu_mesh_patch(handle(), index_, &p));
    state_->counts(index_) = {0, cells[0] * cells[1] * cells[2]};
  }
  /** Makes the piece leaves of octrees of an adaptive mesh. Each leaf has a level (uint8, int32 or
   *  int64) and the index of its lower corner (3 components of int32 or int64, or of a flat mesh 2,
   *  which the Array then says by components(2)). Both are containers, or Arrays with a count. */
  void leaves(const Array& levels, Array corners, const LeafLattice& lattice = {}) {
    insitu_leaves l = insitu_leaves_default();
    l.levels = levels.get(-1, "levels");
    l.corners =
        corners.components(corners.components() == 2 ? 2 : 3).get(l.levels.count, "corners");
    l.corner_bits = lattice.corner_bits;
    std::copy(lattice.offset.begin(), lattice.offset.end(), l.offset);
    detail::check(insitu_mesh_leaves(handle(), index_, &l));
    state_->counts(index_) = {0, l.levels.count};
  }

  /** Gives values on cells, float or double: a scalar, or with components() a vector. A bare
   *  pointer has as many items as the piece has cells. */
  void cell_field(const std::string& name, const Array& values) {
    give_field(name, INSITU_CELL, &values, 1);
  }
  /** Gives a vector on cells, one array a component: {vx, vy, vz}. */
  void cell_field(const std::string& name, std::initializer_list<Array> components) {
    give_field(name, INSITU_CELL, components.begin(), components.size());
  }
  /** Gives values on vertices, as cell_field() does on cells. */
  void vertex_field(const std::string& name, const Array& values) {
    give_field(name, INSITU_VERTEX, &values, 1);
  }
  void vertex_field(const std::string& name, std::initializer_list<Array> components) {
    give_field(name, INSITU_VERTEX, components.begin(), components.size());
  }

  /** Gives a field with the association as a value: one array, or one array a component. */
  void field(const std::string& name, Association association, View<const Array> arrays) {
    give_field(name, static_cast<insitu_association>(association), arrays.data(), arrays.size());
  }

  /** Gives the ghosts, one uint8 a cell; a ghost cell never owns a point and is never drawn. */
  void ghosts(const Array& values, GhostConvention convention = GhostConvention::vtk) {
    const insitu_array a = values.get(counts().cells, "ghosts");
    detail::check(
        insitu_mesh_ghosts(handle(), index_, &a, static_cast<insitu_ghost_convention>(convention)));
  }
  /** Gives the numbers that the piece's cells or vertices have in the mesh of all processes, int32
   * or int64 (insitu_mesh_global_ids). */
  void global_ids(Association association, const Array& values) {
    const bool cells = association == Association::cell;
    const insitu_array a = values.get(cells ? counts().cells : counts().vertices, "global ids");
    detail::check(
        insitu_mesh_global_ids(handle(), index_, static_cast<insitu_association>(association), &a));
  }
  void no_global_ids(Association association) {
    detail::check(insitu_mesh_global_ids(handle(), index_,
                                         static_cast<insitu_association>(association), nullptr));
  }
  /** Gives VTK's vtkGhostType of points, one uint8 a vertex: bit 2 hides
   *  (insitu_mesh_hidden_points). */
  void hidden_points(const Array& values) {
    const insitu_array a = values.get(counts().vertices, "hidden points");
    detail::check(insitu_mesh_hidden_points(handle(), index_, &a));
  }
  void no_hidden_points() { detail::check(insitu_mesh_hidden_points(handle(), index_, nullptr)); }
  void no_ghosts() {
    detail::check(insitu_mesh_ghosts(handle(), index_, nullptr, INSITU_GHOSTS_VTK));
  }

  int index() const noexcept { return index_; }

protected:
  Piece(std::shared_ptr<detail::MeshState> state, int index)
      : state_(std::move(state)), index_(index) {}
  insitu_mesh handle() const noexcept { return state_ ? state_->handle : nullptr; }
  const std::shared_ptr<detail::MeshState>& state() const noexcept { return state_; }

private:
  friend class Mesh;

  detail::MeshState::Counts counts() const {
    return state_ ? state_->counts(index_) : detail::MeshState::Counts{};
  }
  void give_points(std::initializer_list<Array> arrays, int components) {
    std::vector<insitu_array> out;
    for (Array a : arrays) {
      if (a.components() == 1)
        a.components(components);
      out.push_back(a.get(counts().vertices, "points"));
    }
    detail::check(
        insitu_mesh_points(handle(), index_, out.data(), static_cast<std::int32_t>(out.size())));
    state_->counts(index_).vertices = out[0].count;
  }
  void give_cells(insitu_layout layout, Shape shape, int ids, Array& connectivity, int index_base) {
    insitu_cells c = insitu_cells_default();
    c.layout = layout;
    c.shape = static_cast<insitu_shape>(shape);
    c.connectivity = connectivity.components(ids).get(-1, "connectivity");
    c.count = c.connectivity.count;
    c.index_base = index_base;
    give(c);
  }
  void give(const insitu_cells& cells) {
    detail::check(insitu_mesh_cells(handle(), index_, &cells));
    state_->counts(index_).cells = cells.count;
  }
  static insitu_faces faces_of(const Array& vertices, const Array& offsets, int index_base) {
    insitu_faces f = insitu_faces_default();
    f.vertices = vertices.get(-1, "vertices");
    f.offsets = offsets.get(-1, "offsets");
    f.face_count = std::max<std::int64_t>(f.offsets.count - 1, 0);
    f.index_base = index_base;
    return f;
  }
  void give(const insitu_block& block) {
    detail::check(insitu_mesh_block(handle(), index_, &block));
    const std::int64_t* n = block.vertices;
    state_->counts(index_) = {n[0] * n[1] * n[2],
                              (n[0] - 1) * (n[1] - 1) *
                                  (block.dimensions == 2 ? std::int64_t(1) : n[2] - 1)};
  }
  static insitu_block flat(std::int64_t ni, std::int64_t nj) {
    insitu_block b = insitu_block_default();
    b.dimensions = 2;
    set_extent(b, ni, nj, 1);
    return b;
  }
  static void set_extent(insitu_block& b, std::int64_t ni, std::int64_t nj, std::int64_t nk) {
    b.vertices[0] = ni;
    b.vertices[1] = nj;
    b.vertices[2] = nk;
  }
  void give_field(const std::string& name, insitu_association association, const Array* arrays,
                  std::size_t number) {
    const bool cell = association == INSITU_CELL;
    const std::string what = (cell ? "cell_field '" : "vertex_field '") + name + "'";
    std::vector<insitu_array> out;
    for (std::size_t i = 0; i < number; ++i)
      out.push_back(arrays[i].get(cell ? counts().cells : counts().vertices, what));
    detail::check(insitu_mesh_field(handle(), index_, name.c_str(), association, out.data(),
                                    static_cast<std::int32_t>(out.size())));
  }

  std::shared_ptr<detail::MeshState> state_;
  int index_;
};

} // namespace insitu

#endif // INSITU_PIECE_HPP
