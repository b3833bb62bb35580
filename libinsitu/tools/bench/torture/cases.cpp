#include "torture/cases.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace insitu::bench::torture {

namespace {

using math::Vec3d;
using mesh::Shape;
using workload::Kind;
using workload::make_box;
using workload::Mesh;

constexpr double jitter = 0.2;

Mesh moved(Mesh mesh, const std::function<Vec3d(const Vec3d&)>& to) {
  for (std::int64_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3d x = to(mesh.point(v));
    for (int c = 0; c < 3; ++c)
      mesh.points[std::size_t(3 * v + c)] = x[c];
  }
  return mesh;
}

Mesh scaled(Mesh mesh, const Vec3d& scale, double offset = 0.0) {
  return moved(std::move(mesh), [&](const Vec3d& p) {
    return Vec3d{p.x * scale.x + offset, p.y * scale.y + offset, p.z * scale.z + offset};
  });
}

/// Turned so that no axis, edge or face of a box stays parallel to an axis.
Mesh tilted(Mesh mesh) {
  const double a = 0.6, b = 1.1;
  return moved(std::move(mesh), [&](const Vec3d& p) {
    const Vec3d q{std::cos(a) * p.x - std::sin(a) * p.y, std::sin(a) * p.x + std::cos(a) * p.y,
                  p.z};
    return Vec3d{q.x, std::cos(b) * q.y - std::sin(b) * q.z, std::sin(b) * q.y + std::cos(b) * q.z};
  });
}

Mesh rounded_to_float(Mesh mesh) {
  for (double& x : mesh.points)
    x = double(float(x));
  return mesh;
}

/// With types and offsets, so that cells of any shape can be added.
Mesh as_mixed(const Mesh& mesh) {
  Mesh out = mesh;
  out.types.clear();
  out.offsets.assign(1, 0);
  for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
    out.types.push_back(std::uint8_t(mesh.shape(c)));
    out.offsets.push_back(out.offsets.back() + mesh::vertex_count(mesh.shape(c)));
  }
  return out;
}

void add_cell(Mesh& mesh, Shape shape, const std::int32_t* ids) {
  mesh.connectivity.insert(mesh.connectivity.end(), ids, ids + mesh::vertex_count(shape));
  mesh.types.push_back(std::uint8_t(shape));
  mesh.offsets.push_back(std::int64_t(mesh.connectivity.size()));
}

/// Those cells of a and b that are kept; b's vertices follow a's unless both share them.
Mesh joined(const Mesh& a, const Mesh& b, bool share,
            const std::function<bool(int mesh, std::int64_t cell)>& keep) {
  Mesh out;
  out.points = a.points;
  out.cell_size = a.cell_size;
  out.offsets.push_back(0);
  if (!share)
    out.points.insert(out.points.end(), b.points.begin(), b.points.end());
  const Mesh* const meshes[2] = {&a, &b};
  for (int m = 0; m < 2; ++m)
    for (std::int64_t c = 0; c < meshes[m]->cell_count(); ++c) {
      if (!keep(m, c))
        continue;
      std::int32_t ids[8];
      const Shape shape = meshes[m]->shape(c);
      for (int v = 0; v < mesh::vertex_count(shape); ++v)
        ids[v] = meshes[m]->ids(c)[v] + (m == 1 && !share ? std::int32_t(a.vertex_count()) : 0);
      add_cell(out, shape, ids);
    }
  return out;
}

/// Every cell written as a hexahedron with repeated ids: 4, 5 or 6 distinct ones, or 8.
Mesh as_hexahedra(const Mesh& mesh) {
  constexpr std::uint8_t tetrahedron[8] = {0, 1, 2, 2, 3, 3, 3, 3},
                         pyramid[8] = {0, 1, 2, 3, 4, 4, 4, 4}, wedge[8] = {0, 2, 1, 1, 3, 5, 4, 4},
                         hexahedron[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  Mesh out;
  out.points = mesh.points;
  out.cell_size = mesh.cell_size;
  out.uniform_shape = Shape::hexahedron;
  for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
    const Shape shape = mesh.shape(c);
    const auto& order = shape == Shape::tetrahedron ? tetrahedron
                        : shape == Shape::pyramid   ? pyramid
                        : shape == Shape::wedge     ? wedge
                                                    : hexahedron;
    for (const std::uint8_t v : order)
      out.connectivity.push_back(mesh.ids(c)[v]);
  }
  return out;
}

/// Some interior vertices of a box of hexahedra put onto their neighbour in x, none next to
/// another: hexahedra of 7 distinct points. same_id: in the connectivity as well.
Mesh collapsed(int n, bool same_id) {
  Mesh mesh = make_box(Kind::hexahedra, n, 0.5 * jitter);
  const int m = n + 1;
  for (int k = 1; k < n; k += 2)
    for (int j = 1; j < n; j += 2)
      for (int i = 1; i + 1 < n; i += 3) {
        const std::int32_t v = i + m * (j + m * k);
        if (same_id)
          std::replace(mesh.connectivity.begin(), mesh.connectivity.end(), v, v + 1);
        std::copy_n(&mesh.points[std::size_t(3 * v + 3)], 3, &mesh.points[std::size_t(3 * v)]);
      }
  return mesh;
}

/// Voxels: a box cut by planes.
Mesh voxels(int n) {
  Mesh mesh = make_box(Kind::hexahedra, n, 0.0);
  mesh.uniform_shape = Shape::voxel;
  for (std::size_t c = 0; c < mesh.connectivity.size(); c += 8) {
    std::swap(mesh.connectivity[c + 2], mesh.connectivity[c + 3]);
    std::swap(mesh.connectivity[c + 6], mesh.connectivity[c + 7]);
  }
  return mesh;
}

/// Every second hexahedron upside down in its ids.
Mesh half_inverted(int n) {
  Mesh mesh = make_box(Kind::hexahedra, n, jitter);
  for (std::size_t c = 0; c < mesh.connectivity.size(); c += 16)
    std::swap_ranges(&mesh.connectivity[c], &mesh.connectivity[c + 4], &mesh.connectivity[c + 4]);
  return mesh;
}

/// Columns with a dart for a base: at every second vertex in x and y, a re-entrant corner.
Mesh reflex(int n) {
  Mesh mesh = make_box(Kind::hexahedra, n, 0.0);
  const int m = n + 1;
  for (int k = 0; k < m; ++k)
    for (int j = 1; j < n; j += 2)
      for (int i = 1; i < n; i += 2) {
        double* p = &mesh.points[std::size_t(3 * (i + m * (j + m * k)))];
        p[0] += 0.6 / n;
        p[1] += 0.6 / n;
      }
  return tilted(std::move(mesh));
}

/// A layer of cells without thickness, a cell that is a point and one that is an edge.
Mesh flat(int n) {
  Mesh mesh = make_box(Kind::hexahedra, n, jitter);
  const auto plane = std::size_t(3 * (n + 1) * (n + 1));
  const std::size_t k = std::size_t(n) / 2;
  std::copy_n(&mesh.points[plane * k], plane, &mesh.points[plane * (k + 1)]);
  const auto centre = std::int32_t(mesh.vertex_count() / 2);
  mesh.connectivity.insert(mesh.connectivity.end(), 8, centre);
  mesh.connectivity.insert(mesh.connectivity.end(), 4, centre);
  mesh.connectivity.insert(mesh.connectivity.end(), 4, centre + 1);
  return mesh;
}

/// Layer after layer turned about the z axis: faces are bilinear, and strongly curved.
Mesh twisted(int n, double angle) {
  return moved(make_box(Kind::hexahedra, n, 0.5 * jitter), [&](const Vec3d& p) {
    const double a = angle * n * p.z, x = p.x - 0.5, y = p.y - 0.5;
    return Vec3d{std::cos(a) * x - std::sin(a) * y, std::sin(a) * x + std::cos(a) * y, p.z};
  });
}

} // namespace

std::vector<Case> make_cases(int n) {
  const auto box = [&](Kind kind) { return make_box(kind, n, jitter); };
  const Mesh mixed = make_box(Kind::mixed, std::max(n, 4), jitter); // 4: all shapes
  const Mesh hexahedra = box(Kind::hexahedra);
  const int m = n;
  std::vector<Case> cases;
  const auto add = [&](const char* name, Mesh mesh) -> Case& {
    return cases.emplace_back(Case{name, std::move(mesh)});
  };
  const auto add_invalid = [&](const char* name, Mesh mesh) -> Case& {
    Case& c = add(name, std::move(mesh));
    c.valid = false;
    return c;
  };

  add("hexahedra, jittered", hexahedra);
  add("tetrahedra, jittered", box(Kind::tetrahedra));
  add("wedges, jittered", box(Kind::wedges));
  add("pyramids, jittered", box(Kind::pyramids));
  add("mixed shapes, jittered", mixed);
  add("voxels", voxels(n));
  add("hexahedra, twisted", twisted(n, 0.5));
  add("hexahedra, planar tilted quads", tilted(make_box(Kind::hexahedra, n, 0.0)));
  add("hexahedra, quads flat to 1e-15", make_box(Kind::hexahedra, n, 1e-15));
  add("wedges, planar tilted quads", tilted(make_box(Kind::wedges, n, 0.0)));

  add("mixed, offset 1e7", scaled(mixed, {1, 1, 1}, 1e7));
  add("mixed, aspect 1e6", scaled(mixed, {1, 1, 1e-6}));
  add("mixed, aspect 1e6, tilted", tilted(scaled(mixed, {1, 1, 1e-6})));
  add("mixed, needles of 1e6, tilted", tilted(scaled(mixed, {1, 1e-6, 1e-6})));
  add("mixed, offset 1e7, aspect 1e6", scaled(mixed, {1e6, 1e3, 1}, 1e7));
  add("mixed, scale 1e-30", scaled(mixed, {1e-30, 1e-30, 1e-30}));
  add("mixed, scale 1e30", scaled(mixed, {1e30, 1e30, 1e30}));
  const auto shear = [](const Vec3d& p) { return Vec3d{p.x + 1e4 * p.z, p.y + 3e3 * p.z, p.z}; };
  add("slivers: tetrahedra, sheared", moved(box(Kind::tetrahedra), shear));
  add("slivers: hexahedra, sheared", moved(hexahedra, shear));
  add("hexahedra, graded 1e4", make_box(Kind::hexahedra, n, jitter, workload::Spacing::graded));
  add("wedges, layers 1e6", make_box(Kind::wedges, n, jitter, workload::Spacing::layers));
  add("mixed, float32", rounded_to_float(mixed)).float32 = true;
  add("mixed, float32, offset 1e3", rounded_to_float(scaled(mixed, {1, 1, 1}, 1e3))).float32 = true;

  add("hexahedra of 4 to 6 vertices", as_hexahedra(mixed));
  add("hexahedra of 7 vertices", collapsed(std::max(n, 4), true));
  add("hexahedra, coincident vertices", collapsed(std::max(n, 4), false));
  add("mixed, all inverted", scaled(mixed, {-1, 1, 1}));
  add("hexahedra, half inverted", half_inverted(n));

  add_invalid("hexahedra, jitter 0.5", make_box(Kind::hexahedra, n, 0.5));
  add_invalid("hexahedra, twisted by folds", twisted(n, 2.0));
  add_invalid("mixed, tangled", make_box(Kind::mixed, std::max(n, 4), 0.9));
  add_invalid("hexahedra, reflex angles", reflex(n));
  add_invalid("flat cells, edges, points", flat(n));
  // Two halves with the same vertices, whose jittered faces between them do not match.
  add_invalid("quads against two triangles",
              joined(hexahedra, box(Kind::tetrahedra), true,
                     [m](int mesh, std::int64_t c) {
                       return (c / (mesh == 0 ? 1 : 6) % m < m / 2) == (mesh == 0);
                     }))
      .conforming = false;
  add_invalid("coarse beside fine",
              joined(hexahedra, scaled(make_box(Kind::hexahedra, 2 * n, jitter), {0.98, 1, 1}),
                     false,
                     [m](int mesh, std::int64_t c) {
                       return mesh == 0 ? c % m < m / 2 : c % (2 * m) >= 2 * (m / 2);
                     }))
      .conforming = false;
  add_invalid("every cell twice",
              joined(as_mixed(mixed), mixed, true, [](int, std::int64_t) { return true; }))
      .conforming = false;
  return cases;
}

} // namespace insitu::bench::torture
