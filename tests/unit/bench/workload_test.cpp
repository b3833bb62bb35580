#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "cells/checks/folds.h"
#include "cells/exact/contain_exact.h"
#include "cells/kernels/faces.h"
#include "core/random.h"
#include "count_faces.h"
#include "workload/mesh.h"
#include "workload/queries.h"

namespace insitu::workload {
namespace {

using math::Vec3d;
using mesh::Shape;

constexpr Kind all_kinds[] = {Kind::hexahedra, Kind::tetrahedra, Kind::wedges, Kind::pyramids,
                              Kind::mixed};

double signed_tetrahedron(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return dot(a, cross(b, c)) / 6.0;
}

/// The volume that the outward faces enclose; exactly the cell's, bilinear quads included, since
/// the flux through a bilinear patch is the mean of that through its two triangulations.
double volume(const Mesh& mesh, std::int64_t cell) {
  Vec3d x[8];
  mesh.gather(cell, x);
  const cells::FaceTable table = cells::face_table(mesh.shape(cell));
  double sum = 0.0;
  for (int f = 0; f < table.face_count; ++f) {
    const auto* v = table.faces[f].vertices;
    const Vec3d a = x[v[0]] - x[0], b = x[v[1]] - x[0], c = x[v[2]] - x[0];
    if (table.faces[f].vertex_count == 3) {
      sum += signed_tetrahedron(a, b, c);
      continue;
    }
    const Vec3d d = x[v[3]] - x[0];
    sum += 0.5 * (signed_tetrahedron(a, b, c) + signed_tetrahedron(a, c, d) +
                  signed_tetrahedron(a, b, d) + signed_tetrahedron(b, c, d));
  }
  return sum;
}

bool on_box(const Mesh& mesh, const std::vector<std::int32_t>& face) {
  for (int a = 0; a < 3; ++a)
    for (const double side : {0.0, 1.0})
      if (std::all_of(face.begin(), face.end(),
                      [&](std::int32_t v) { return mesh.point(v)[a] == side; }))
        return true;
  return false;
}

TEST(Workload, InteriorFacesAreSharedByExactlyTwoCells) {
  for (const Kind kind : all_kinds)
    for (const int n : {1, 2, 5, 9}) {
      const Mesh mesh = make_box(kind, n, 0.2);
      int inner = 0;
      for (const auto& [face, cells] : count_faces(mesh)) {
        EXPECT_EQ(cells, on_box(mesh, face) ? 1 : 2) << name(kind) << ' ' << n;
        inner += cells == 2;
      }
      EXPECT_TRUE(inner > 0 || n == 1);
    }
}

TEST(Workload, CellsByFacesAreTheCells) {
  for (const Kind kind : all_kinds) {
    const Mesh cells = make_box(kind, 8, 0.2), faces = by_faces(cells);
    ASSERT_EQ(faces.cell_count(), cells.cell_count()) << name(kind);
    EXPECT_EQ(faces.points, cells.points);
    std::vector<int> sides(faces.face_offsets.size() - 1, 0);
    for (std::int64_t c = 0; c < cells.cell_count(); ++c) {
      std::set<std::int32_t> of_faces;
      for (std::int64_t k = faces.cell_offsets[std::size_t(c)];
           k < faces.cell_offsets[std::size_t(c) + 1]; ++k) {
        const auto f = std::size_t(faces.cell_faces[std::size_t(k)]);
        ++sides[f];
        of_faces.insert(faces.face_vertices.begin() + faces.face_offsets[f],
                        faces.face_vertices.begin() + faces.face_offsets[f + 1]);
      }
      const std::int32_t* const ids = cells.ids(c);
      EXPECT_EQ(of_faces, std::set<std::int32_t>(ids, ids + mesh::vertex_count(cells.shape(c))));
    }
    for (std::size_t f = 0; f < sides.size(); ++f) { // on the box's sides one, else two
      const std::vector<std::int32_t> face(faces.face_vertices.begin() + faces.face_offsets[f],
                                           faces.face_vertices.begin() + faces.face_offsets[f + 1]);
      ASSERT_EQ(sides[f], on_box(faces, face) ? 1 : 2) << name(kind);
    }
  }
  EXPECT_EQ(make_box(kind_from_name("hexfaces").value(), 4, 0.2).cell_faces,
            by_faces(make_box(Kind::hexahedra, 4, 0.2)).cell_faces);
}

TEST(Workload, VolumesArePositiveAndFillTheBox) {
  for (const Kind kind : all_kinds)
    for (const double jitter : {0.0, 0.15}) {
      const Mesh mesh = make_box(kind, 9, jitter);
      double sum = 0.0, least = 1.0;
      for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
        const double v = volume(mesh, c);
        least = std::min(least, v);
        sum += v;
      }
      EXPECT_GT(least, 0.0) << name(kind) << ' ' << jitter;
      EXPECT_NEAR(sum, 1.0, 1e-12) << name(kind) << ' ' << jitter;
    }
}

TEST(Workload, TwistedCellsAreBentAndDoNotFold) {
  for (const int n : {3, 8}) {
    const Mesh mesh = make_twisted_box(n, 0.4);
    double sum = 0.0, bent = 0.0;
    for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
      Vec3d x[8];
      mesh.gather(c, x);
      EXPECT_FALSE(cells::jacobian_changes_sign(Shape::hexahedron, x)) << "cell " << c;
      sum += volume(mesh, c);
      // How far the diagonals of a face across x pass each other, in edges.
      const Vec3d apart = 0.5 * n * (x[0] - x[3] + x[7] - x[4]);
      bent = std::max(bent, std::sqrt(dot(apart, apart)));
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_GT(bent, n == 3 ? 0.4 : 0.8);
  }
}

TEST(Workload, CountsAndSizes) {
  EXPECT_EQ(box_size(Kind::hexahedra, 1'000'000), 100);
  EXPECT_EQ(box_size(Kind::hexahedra, 8'000'000), 200);
  EXPECT_EQ(box_size(Kind::tetrahedra, 1'000'000), 55);
  EXPECT_EQ(box_size(Kind::tetrahedra, 8'000'000), 110);
  EXPECT_EQ(box_size(Kind::wedges, 1'000'000), 79);
  EXPECT_EQ(box_size(Kind::wedges, 8'000'000), 159);
  EXPECT_EQ(box_size(Kind::hexahedra, 1), 1);
  for (const Kind kind : all_kinds)
    for (const int n : {1, 3, 8, 9}) {
      const Mesh mesh = make_box(kind, n, 0.2);
      EXPECT_EQ(mesh.cell_count(), box_cell_count(kind, n)) << name(kind) << ' ' << n;
      EXPECT_EQ(box_size(kind, mesh.cell_count()), n) << name(kind);
      // Every vertex is used.
      const std::set<std::int32_t> used(mesh.connectivity.begin(), mesh.connectivity.end());
      EXPECT_EQ(std::int64_t(used.size()), mesh.vertex_count());
    }
  const Mesh hexahedra = make_box(Kind::hexahedra, 3, 0.2);
  EXPECT_EQ(hexahedra.vertex_count(), 64);
  EXPECT_EQ(make_box(Kind::pyramids, 3, 0.2).vertex_count(), 64 + 27);
}

TEST(Workload, MixedHoldsEveryShape) {
  const Mesh mesh = make_box(Kind::mixed, 4, 0.2);
  const std::set<std::uint8_t> shapes(mesh.types.begin(), mesh.types.end());
  EXPECT_EQ(shapes, (std::set<std::uint8_t>{10, 12, 13, 14}));
}

TEST(Workload, VerticesAreWhereTheWorkloadSays) {
  const int n = 4;
  const Mesh mesh = make_box(Kind::hexahedra, n, 0.2);
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const int v = i + (n + 1) * (j + (n + 1) * k);
        const bool inner = i % n != 0 && j % n != 0 && k % n != 0;
        const int ijk[3] = {i, j, k};
        for (int c = 0; c < 3; ++c) {
          double x = double(ijk[c]) / n;
          if (inner)
            x += 0.2 / n * (2.0 * core::random_unit(1, std::uint64_t(v), std::uint64_t(c)) - 1.0);
          EXPECT_EQ(mesh.point(v)[c], x);
        }
      }
  // The first hexahedron, in VTK's order.
  const std::int32_t expected[8] = {0, 1, 6, 5, 25, 26, 31, 30};
  EXPECT_TRUE(std::equal(expected, expected + 8, mesh.ids(0)));
}

/// All queries but a few, which rounding has put across a face, lie in the cell they were made in.
void expect_inside(const Mesh& mesh, const Queries& q) {
  std::size_t elsewhere = 0;
  for (std::size_t i = 0; i < q.points.size(); ++i) {
    Vec3d x[8];
    mesh.gather(q.made_in[i], x);
    elsewhere +=
        !cells::holds(cells::contain_exact(mesh.shape(q.made_in[i]), x, q.points[i]).where);
  }
  EXPECT_LE(elsewhere, q.points.size() / 1000);
}

TEST(Workload, QueriesLieInTheirCells) {
  for (const Kind kind : all_kinds) {
    const Mesh mesh = make_box(kind, 5, 0.15);
    const Queries uniform = make_queries(mesh, Pattern::uniform, 0);
    EXPECT_EQ(std::int64_t(uniform.points.size()), mesh.cell_count());
    EXPECT_EQ(uniform.made_in.back(), mesh.cell_count() - 1);
    expect_inside(mesh, uniform);
    const Queries random = make_queries(mesh, Pattern::random, 2000);
    ASSERT_EQ(random.points.size(), 2000u);
    expect_inside(mesh, random);
    EXPECT_EQ(random.made_in[7],
              std::int32_t(core::random_bits(2, 7, 0) % std::uint64_t(mesh.cell_count())));
  }
}

TEST(Workload, SortedIsRandomInAnotherOrder) {
  const Mesh mesh = make_box(Kind::hexahedra, 6, 0.2);
  const auto order = [](const Vec3d& a, const Vec3d& b) {
    return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
  };
  Queries random = make_queries(mesh, Pattern::random, 5000);
  Queries sorted = make_queries(mesh, Pattern::sorted, 5000);
  const auto path = [](const Queries& q) {
    double length = 0.0;
    for (std::size_t i = 1; i < q.points.size(); ++i) {
      const Vec3d step = q.points[i] - q.points[i - 1];
      length += std::sqrt(dot(step, step));
    }
    return length;
  };
  EXPECT_LT(path(sorted), 0.25 * path(random));
  expect_inside(mesh, sorted); // made_in went along
  std::sort(random.points.begin(), random.points.end(), order);
  std::sort(sorted.points.begin(), sorted.points.end(), order);
  EXPECT_TRUE(random.points == sorted.points);
}

TEST(Workload, MarchedPointsAreHalfACellApartAndInside) {
  const Mesh mesh = make_box(Kind::hexahedra, 10, 0.2);
  const Queries q = make_queries(mesh, Pattern::march, 4000);
  ASSERT_EQ(q.points.size(), 4000u);
  EXPECT_TRUE(q.made_in.empty());
  int steps = 0;
  for (std::size_t i = 0; i < q.points.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(q.points[i][a], 0.0);
      EXPECT_LE(q.points[i][a], 1.0);
    }
    if (i > 0) {
      const Vec3d d = q.points[i] - q.points[i - 1];
      steps += std::fabs(std::sqrt(dot(d, d)) - 0.05) < 1e-12;
    }
  }
  EXPECT_GT(steps, 3500);
}

TEST(Workload, BoundaryPointsTouchTheirFeature) {
  const Mesh mesh = make_box(Kind::mixed, 6, 0.2);
  const Queries vertices = make_queries(mesh, Pattern::vertices, 300);
  for (std::size_t i = 0; i < vertices.points.size(); ++i) {
    Vec3d x[8];
    const int n = mesh.gather(vertices.made_in[i], x);
    EXPECT_TRUE(std::find(x, x + n, vertices.points[i]) != x + n);
    EXPECT_EQ(cells::contain_exact(mesh.shape(vertices.made_in[i]), x, vertices.points[i]).where,
              cells::Containment::on_vertex);
  }
  for (const Pattern feature : {Pattern::edges, Pattern::faces}) {
    const Queries q = make_queries(mesh, feature, 300);
    ASSERT_EQ(q.points.size(), 300u);
    for (std::size_t i = 0; i < q.points.size();
         ++i) { // a nudge towards the cell's middle is inside
      Vec3d x[8], middle;
      const int n = mesh.gather(q.made_in[i], x);
      for (int v = 0; v < n; ++v)
        middle += x[v] / double(n);
      const Shape shape = mesh.shape(q.made_in[i]);
      const Vec3d in = q.points[i] + 1e-9 * (middle - q.points[i]);
      EXPECT_EQ(cells::contain_exact(shape, x, in).where, cells::Containment::inside);
      const Vec3d out = q.points[i] - 1e-9 * (middle - q.points[i]);
      EXPECT_EQ(cells::contain_exact(shape, x, out).where, cells::Containment::outside);
    }
  }
}

TEST(Workload, RenumberingKeepsTheMesh) {
  for (const Kind kind : all_kinds) {
    const Mesh mesh = make_box(kind, 5, 0.2), other = renumbered(mesh);
    ASSERT_EQ(other.cell_count(), mesh.cell_count());
    ASSERT_EQ(other.vertex_count(), mesh.vertex_count());
    EXPECT_NE(other.connectivity, mesh.connectivity);
    const auto cells = [](const Mesh& m) {
      std::vector<std::vector<std::array<double, 3>>> all;
      for (std::int64_t c = 0; c < m.cell_count(); ++c) {
        Vec3d x[8];
        const int n = m.gather(c, x);
        auto& cell = all.emplace_back();
        for (int v = 0; v < n; ++v)
          cell.push_back({x[v].x, x[v].y, x[v].z});
      }
      std::sort(all.begin(), all.end());
      return all;
    };
    EXPECT_TRUE(cells(mesh) == cells(other)) << name(kind);
  }
  auto p = permutation(1000, 6, 0);
  std::sort(p.begin(), p.end());
  for (int i = 0; i < 1000; ++i)
    ASSERT_EQ(p[std::size_t(i)], i);
}

} // namespace
} // namespace insitu::workload
