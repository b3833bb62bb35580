#include "workload/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <span>
#include <utility>

#include "core/random.h"
#include "workload/lattice.h"

namespace insitu::workload {

namespace {

using math::Vec3d;
using mesh::Shape;

constexpr std::uint8_t tetrahedra_of_hexahedron[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                                         {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
// The first triangle faces away from the second, as VTK has it.
constexpr std::uint8_t wedges_of_hexahedron[2][6] = {{0, 2, 1, 4, 6, 5}, {0, 3, 2, 4, 7, 6}};

/// A face of a hexahedron, counterclockwise seen from inside and starting at the diagonal that the
/// cuts into tetrahedra and wedges share; then the step towards the neighbour behind it.
struct InwardFace {
  std::uint8_t vertices[4];
  std::int8_t step[3];
};
constexpr InwardFace inward_faces[6] = {{{0, 3, 7, 4}, {-1, 0, 0}}, {{1, 5, 6, 2}, {1, 0, 0}},
                                        {{0, 4, 5, 1}, {0, -1, 0}}, {{3, 2, 6, 7}, {0, 1, 0}},
                                        {{0, 1, 2, 3}, {0, 0, -1}}, {{4, 7, 6, 5}, {0, 0, 1}}};

enum class Cut { none, tetrahedra, wedges, centre };
constexpr Cut mixed_slabs[8] = {Cut::none,   Cut::wedges, Cut::centre, Cut::tetrahedra,
                                Cut::centre, Cut::wedges, Cut::none,   Cut::none};

Cut cut_at(Kind kind, int i) {
  switch (kind) {
  case Kind::hexahedra:
  case Kind::hexahedra_by_faces:
    return Cut::none;
  case Kind::tetrahedra:
    return Cut::tetrahedra;
  case Kind::wedges:
    return Cut::wedges;
  case Kind::pyramids:
    return Cut::centre;
  case Kind::mixed:
  case Kind::polyhedra: // are no cut hexahedra
    break;
  }
  return mixed_slabs[i % 8];
}

/// Whether the hexahedra of a slab have triangles on the faces that look along x. (Across y and z a
/// slab meets itself only.)
bool splits_x_faces(Kind kind, int i, int n) {
  return i >= 0 && i < n && cut_at(kind, i) == Cut::tetrahedra;
}

class Builder {
public:
  Builder(Kind kind, int n, double jitter, Spacing spacing)
      : kind_(kind), n_(n), lattice_(spacing, n, jitter) {
    const auto cells = std::size_t(filled_share(spacing) * double(box_cell_count(kind, n)));
    if (kind == Kind::mixed) {
      mesh_.types.reserve(cells);
      mesh_.offsets.reserve(cells + 1);
      mesh_.offsets.push_back(0);
    } else {
      mesh_.uniform_shape = kind == Kind::hexahedra    ? Shape::hexahedron
                            : kind == Kind::tetrahedra ? Shape::tetrahedron
                            : kind == Kind::wedges     ? Shape::wedge
                                                       : Shape::pyramid;
      mesh_.connectivity.reserve(cells * std::size_t(mesh::vertex_count(mesh_.uniform_shape)));
    }
    mesh_.cell_size = 1.0 / n;
    mesh_.smallest_edge = lattice_.smallest_step();
    // Corners first, so that the centres' ids come behind them.
    walk(
        [&](int i, int j, int k) {
          const Vec3d x = lattice_.corner(i, j, k);
          mesh_.points.insert(mesh_.points.end(), {x.x, x.y, x.z});
        },
        [](int, const std::int32_t*) {});
    walk([](int, int, int) {}, [&](int i, const std::int32_t* v) { hexahedron(i, v); });
  }
  Mesh take() { return std::move(mesh_); }

private:
  /// Calls on_corner(i, j, k) for every corner of a block that is there, in the order of their ids,
  /// and on_block(i, ids of its corners) for every such block.
  template <class OnCorner, class OnBlock>
  void walk(OnCorner&& on_corner, OnBlock&& on_block) const {
    const auto n = std::size_t(n_), m = n + 1;
    std::vector<std::uint8_t> behind, ahead; // the blocks before and after a plane of corners
    std::vector<std::int32_t> ids(m * m), before;
    std::int32_t next = 0;
    lattice_.fill_plane(-1, ahead);
    for (int k = 0; k <= n_; ++k) {
      behind.swap(ahead);
      lattice_.fill_plane(k, ahead);
      before = ids;
      std::fill(ids.begin(), ids.end(), -1);
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t i = 0; i < n; ++i)
          if (behind[i + n * j] || ahead[i + n * j])
            for (const std::size_t at :
                 {i + m * j, i + 1 + m * j, i + m * (j + 1), i + 1 + m * (j + 1)})
              ids[at] = 0;
      for (std::size_t at = 0; at < m * m; ++at)
        if (ids[at] == 0) {
          ids[at] = next++;
          on_corner(int(at % m), int(at / m), k);
        }
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t i = 0; i < n; ++i) {
          if (!behind[i + n * j])
            continue;
          const std::size_t at = i + m * j;
          const std::int32_t v[8] = {before[at], before[at + 1], before[at + m + 1], before[at + m],
                                     ids[at],    ids[at + 1],    ids[at + m + 1],    ids[at + m]};
          on_block(int(i), v);
        }
    }
  }

  void add(Shape shape, const std::int32_t* ids) {
    mesh_.connectivity.insert(mesh_.connectivity.end(), ids, ids + mesh::vertex_count(shape));
    if (kind_ == Kind::mixed) {
      mesh_.types.push_back(std::uint8_t(shape));
      mesh_.offsets.push_back(std::int64_t(mesh_.connectivity.size()));
    }
  }

  template <std::size_t cells, std::size_t vertices>
  void add_parts(Shape shape, const std::uint8_t (&parts)[cells][vertices], const std::int32_t* v) {
    for (const auto& part : parts) {
      std::int32_t ids[vertices];
      for (std::size_t p = 0; p < vertices; ++p)
        ids[p] = v[part[p]];
      add(shape, ids);
    }
  }

  void hexahedron(int i, const std::int32_t* v) {
    switch (cut_at(kind_, i)) {
    case Cut::none:
      add(Shape::hexahedron, v);
      break;
    case Cut::tetrahedra:
      add_parts(Shape::tetrahedron, tetrahedra_of_hexahedron, v);
      break;
    case Cut::wedges:
      add_parts(Shape::wedge, wedges_of_hexahedron, v);
      break;
    case Cut::centre:
      about_centre(i, v);
      break;
    }
  }

  void about_centre(int i, const std::int32_t* v) {
    const auto centre = std::int32_t(mesh_.vertex_count());
    Vec3d sum;
    for (int a = 0; a < 8; ++a)
      sum += mesh_.point(v[a]);
    for (int c = 0; c < 3; ++c)
      mesh_.points.push_back(0.125 * sum[c]);
    for (const InwardFace& face : inward_faces) {
      const std::int32_t q[4] = {v[face.vertices[0]], v[face.vertices[1]], v[face.vertices[2]],
                                 v[face.vertices[3]]};
      if (face.step[0] != 0 && splits_x_faces(kind_, i + face.step[0], n_)) {
        const std::int32_t two[2][4] = {{q[0], q[1], q[2], centre}, {q[0], q[2], q[3], centre}};
        add(Shape::tetrahedron, two[0]);
        add(Shape::tetrahedron, two[1]);
      } else {
        const std::int32_t ids[5] = {q[0], q[1], q[2], q[3], centre};
        add(Shape::pyramid, ids);
      }
    }
  }

  Kind kind_;
  int n_;
  Lattice lattice_;
  Mesh mesh_;
};

} // namespace

const char* name(Kind kind) {
  constexpr const char* names[] = {"hex", "tet", "wedge", "pyramid", "mixed", "poly", "hexfaces"};
  return names[int(kind)];
}

std::optional<Kind> kind_from_name(std::string_view text) {
  for (int k = 0; k < 7; ++k)
    if (text == name(Kind(k)))
      return Kind(k);
  return std::nullopt;
}

const char* name(Spacing spacing) {
  constexpr const char* names[] = {"even", "graded", "layers", "sparse"};
  return names[int(spacing)];
}

std::optional<Spacing> spacing_from_name(std::string_view text) {
  for (int s = 0; s < 4; ++s)
    if (text == name(Spacing(s)))
      return Spacing(s);
  return std::nullopt;
}

std::int64_t Mesh::cell_count() const {
  if (has_faces())
    return std::int64_t(cell_offsets.size()) - 1;
  if (!types.empty())
    return std::int64_t(types.size());
  const int n = mesh::vertex_count(uniform_shape);
  return n == 0 ? 0 : std::int64_t(connectivity.size()) / n;
}

int Mesh::gather(std::int64_t cell, Vec3d* x) const {
  const std::int32_t* v = ids(cell);
  const int n = mesh::vertex_count(shape(cell));
  for (int a = 0; a < n; ++a)
    x[a] = point(v[a]);
  return n;
}

Mesh make_box(Kind kind, int n, double jitter, Spacing spacing) {
  if (kind == Kind::hexahedra_by_faces)
    return by_faces(make_box(Kind::hexahedra, n, jitter, spacing));
  return kind == Kind::polyhedra ? make_octahedra(n, jitter)
                                 : Builder(kind, n, jitter, spacing).take();
}

Mesh make_twisted_box(int n, double amplitude) {
  Mesh mesh = make_box(Kind::hexahedra, n, 0.0);
  const double reach = amplitude / n;
  for (std::size_t v = 0; v < mesh.points.size(); v += 3) {
    double* p = &mesh.points[v];
    int ijk[3];
    bool interior = true;
    for (int a = 0; a < 3; ++a) {
      ijk[a] = int(std::lround(p[a] * n));
      interior = interior && ijk[a] > 0 && ijk[a] < n;
    }
    if (!interior)
      continue;
    p[0] += (ijk[1] + ijk[2]) % 2 == 0 ? reach : -reach;
    p[1] += (ijk[0] + ijk[2]) % 2 == 0 ? -reach : reach;
  }
  return mesh;
}

std::int64_t box_cell_count(Kind kind, int n) {
  if (kind == Kind::polyhedra)
    return std::int64_t(n) * n * n + std::int64_t(n - 1) * (n - 1) * (n - 1);
  std::int64_t across = 0; // cells in a row of hexahedra along x
  for (int i = 0; i < n; ++i)
    switch (cut_at(kind, i)) {
    case Cut::none:
      across += 1;
      break;
    case Cut::tetrahedra:
      across += 6;
      break;
    case Cut::wedges:
      across += 2;
      break;
    case Cut::centre:
      across += 6 + splits_x_faces(kind, i - 1, n) + splits_x_faces(kind, i + 1, n);
      break;
    }
  return across * n * n;
}

int box_size(Kind kind, std::int64_t cells, Spacing spacing) {
  int n = 1;
  cells = std::int64_t(double(cells) / filled_share(spacing));
  while (box_cell_count(kind, n + 1) <= cells)
    ++n;
  const std::int64_t below = box_cell_count(kind, n), above = box_cell_count(kind, n + 1);
  return above - cells < std::llabs(cells - below) ? n + 1 : n;
}

std::vector<double> vertex_field(const Mesh& mesh) {
  std::vector<double> f(std::size_t(mesh.vertex_count()));
  for (std::size_t v = 0; v < f.size(); ++v)
    f[v] = field(mesh.point(std::int64_t(v)));
  return f;
}

std::vector<std::int32_t> permutation(std::int64_t n, std::uint64_t seed, std::uint64_t channel) {
  std::vector<std::int32_t> p(static_cast<std::size_t>(n));
  std::iota(p.begin(), p.end(), 0);
  for (std::size_t i = p.size(); i-- > 1;)
    std::swap(p[i], p[core::random_bits(seed, i, channel) % (i + 1)]);
  return p;
}

Mesh renumbered(const Mesh& mesh) {
  const auto new_vertex = permutation(mesh.vertex_count(), 6, 0); // by the old id
  const auto old_cell = permutation(mesh.cell_count(), 6, 1);     // by the new id
  Mesh out;
  out.uniform_shape = mesh.uniform_shape;
  out.cell_size = mesh.cell_size;
  out.smallest_edge = mesh.smallest_edge;
  out.points.resize(mesh.points.size());
  for (std::size_t v = 0; v < new_vertex.size(); ++v)
    std::copy_n(&mesh.points[3 * v], 3, &out.points[3 * std::size_t(new_vertex[v])]);
  out.connectivity.reserve(mesh.connectivity.size());
  if (!mesh.types.empty())
    out.offsets.push_back(0);
  for (const std::int32_t old : old_cell) {
    const std::int32_t* ids = mesh.ids(old);
    for (int a = 0; a < mesh::vertex_count(mesh.shape(old)); ++a)
      out.connectivity.push_back(new_vertex[std::size_t(ids[a])]);
    if (!mesh.types.empty()) {
      out.types.push_back(mesh.types[std::size_t(old)]);
      out.offsets.push_back(std::int64_t(out.connectivity.size()));
    }
  }
  return out;
}

} // namespace insitu::workload
