#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "math/vec.h"
#include "mesh/shape.h"

/// The standard workload: meshes and points that are the same in every program that is compared.
/// Random numbers are core::random_bits and core::random_unit, with a seed a purpose: 1 jitter, 2
/// random queries, 3 to 5 boundary sets, 6 renumbering, 8 islands.
namespace insitu::workload {

enum class Kind { hexahedra, tetrahedra, wedges, pyramids, mixed, polyhedra, hexahedra_by_faces };

/// "hex", "tet", "wedge", "pyramid", "mixed", "poly", "hexfaces".
const char* name(Kind kind);
std::optional<Kind> kind_from_name(std::string_view name);

/// How the box is divided into the hexahedra that cells are cut from.
///  - even: n equal steps along each axis.
///  - graded: steps that grow geometrically from one end to the other, 1e4-fold, along each axis.
///  - layers: even in x and y, thin in z: steps that grow from 1e-6 / n to 1e-4 / n, so that cells
///    are 1e4 to 1e6 times as wide as thick.
///  - sparse: the blocks of an even box that lie in one of 24 balls, about 5 % of the box.
enum class Spacing { even, graded, layers, sparse };

/// "even", "graded", "layers", "sparse".
const char* name(Spacing spacing);
std::optional<Spacing> spacing_from_name(std::string_view name);

/// A mesh in arrays as a solver keeps them. Cells of one shape have no types and no offsets: cell c
/// has its ids from vertex_count(uniform_shape) * c. Otherwise cell c has its ids at
/// [offsets[c], offsets[c + 1]).
struct Mesh {
  std::vector<double> points; ///< interleaved x, y, z
  std::vector<std::int32_t> connectivity;
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets;
  mesh::Shape uniform_shape = mesh::Shape::none;
  /// Of polyhedra, in place of these: face f has its vertices at [face_offsets[f], face_offsets[f +
  /// 1]), cell c its faces at [cell_offsets[c], cell_offsets[c + 1]).
  std::vector<std::int32_t> face_vertices, cell_faces;
  std::vector<std::int64_t> face_offsets, cell_offsets;
  bool has_faces() const { return !cell_offsets.empty(); }
  /// The mean edge in x of the hexahedra that the cells were cut from; twice the step of marched
  /// queries.
  double cell_size = 0.0;
  /// The shortest edge of those before the jitter.
  double smallest_edge = 0.0;

  std::int64_t cell_count() const;
  std::int64_t vertex_count() const { return std::int64_t(points.size() / 3); }
  mesh::Shape shape(std::int64_t cell) const {
    return types.empty() ? uniform_shape : mesh::Shape(types[std::size_t(cell)]);
  }
  const std::int32_t* ids(std::int64_t cell) const {
    return connectivity.data() +
           (types.empty() ? cell * mesh::vertex_count(uniform_shape) : offsets[std::size_t(cell)]);
  }
  math::Vec3d point(std::int64_t vertex) const {
    const double* p = points.data() + 3 * vertex;
    return {p[0], p[1], p[2]};
  }
  /// Fills x with the cell's vertices; returns how many.
  int gather(std::int64_t cell, math::Vec3d* x) const;
};

/// Box [0, 1]^3 (thinner for layers) of n^3 hexahedra whose interior vertices are jittered by up to
/// `jitter` of the shorter neighbouring step a component, cut into cells of the kind, x fastest.
/// Every cell has a positive volume by VTK's rule as long as the jitter does not fold it.
///  - tetrahedra: six a hexahedron, about its diagonal 0-6.
///  - wedges: two a hexahedron, cut along 0-2 and 4-6.
///  - pyramids: six a hexahedron, about its vertices' average, a vertex of its own.
///  - mixed: slabs across x, of all four shapes, conforming. In a period of eight slabs: hexahedra,
///    wedges, centre, tetrahedra, centre, wedges, hexahedra, hexahedra; where `centre` is cut about
///    the vertices' average, into a pyramid a face or, where the neighbour's face is cut into
///    triangles, two tetrahedra.
///  - polyhedra: truncated octahedra instead, about the middles of the cubes and the inner corners
///    of a lattice; the spacing is even, and the jitter a share of a quarter of a cube.
///  - hexahedra_by_faces: hexahedra, with their faces in the place of their vertices.
Mesh make_box(Kind kind, int n, double jitter, Spacing spacing = Spacing::even);
Mesh make_octahedra(int n, double jitter);
/// The same cells, given by their faces.
Mesh by_faces(Mesh mesh);
/// The even box of n^3 hexahedra, twisted: interior vertices move by +-amplitude / n in x and in y,
/// by turns, so that every interior cell's two ends are turned or sheared in opposite directions
/// and the quads between them are bent as far. Up to an amplitude of 0.45 no cell folds.
Mesh make_twisted_box(int n, double amplitude);

/// The n whose box of that kind has the number of cells nearest to `cells` (about, for sparse); at
/// least 1.
int box_size(Kind kind, std::int64_t cells, Spacing spacing = Spacing::even);
/// How many cells the full box has.
std::int64_t box_cell_count(Kind kind, int n);

/// The field of all checks, x + 2 y + 3 z.
inline double field(const math::Vec3d& p) {
  return p.x + 2.0 * p.y + 3.0 * p.z;
}
/// Its values at the vertices.
std::vector<double> vertex_field(const Mesh& mesh);

/// A permutation of [0, n): Fisher and Yates's shuffle by random_bits(seed, i, channel).
std::vector<std::int32_t> permutation(std::int64_t n, std::uint64_t seed, std::uint64_t channel);
/// The same mesh with its cells and vertices renumbered at random.
Mesh renumbered(const Mesh& mesh);

} // namespace insitu::workload
