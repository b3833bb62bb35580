// Faces against a map of all of them; triangles against where the cells are.
#include <algorithm>
#include <array>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <numeric>

#include "accel/faces/mesh_faces.h"
#include "cells/kernels/faces.h"
#include "face_key.h"
#include "fixtures/committed.h"
#include "odd_mesh.h"

using namespace insitu;
using accel::FaceTriangle;
using accel::MeshFaces;
using accel::Method;
using accel::none;
using math::Vec3d;
using test::Key;
using test::key_of;
using test::MeshKind;
using test::TestMesh;

namespace {

constexpr MeshKind all_kinds[] = {MeshKind::hexahedra, MeshKind::voxels,     MeshKind::wedges,
                                  MeshKind::pyramids,  MeshKind::tetrahedra, MeshKind::mixed};

using Oracle = std::map<Key, std::vector<std::uint32_t>>;

Oracle brute_force(const mesh::MeshView& view) {
  Oracle faces;
  for (std::int64_t flat = 0; flat < view.cell_count(); ++flat) {
    mesh::CellVertices cell;
    mesh::gather(view, flat, cell);
    if (!view.pieces[cell.piece].owns(flat - view.first_cell[cell.piece]))
      continue;
    const cells::FaceTable table = cells::face_table(cell.shape);
    for (int f = 0; f < table.face_count; ++f) {
      std::vector<std::uint32_t> cycle;
      for (int k = 0; k < table.faces[f].vertex_count; ++k)
        cycle.push_back(
            std::uint32_t(view.first_vertex[cell.piece] + cell.ids[table.faces[f].vertices[k]]));
      if (Key key; key_of(cycle, key))
        faces[key].push_back(std::uint32_t(flat));
    }
  }
  return faces;
}

void expect_faces(const mesh::MeshView& view, const core::Threads& threads,
                  const std::string& what) {
  core::Memory memory;
  MeshFaces table(memory);
  table.build(view, threads);
  Oracle wanted = brute_force(view);
  std::int64_t boundary = 0, crowded = 0, faces = 0;
  for (const auto& [key, cells] : wanted) {
    boundary += cells.size() == 1;
    crowded += cells.size() > 2;
    faces += cells.size() < 3 ? 1 : std::int64_t(cells.size()) - 1;
  }
  EXPECT_EQ(table.boundary_faces(), boundary) << what;
  EXPECT_EQ(table.crowded_faces(), crowded) << what;
  EXPECT_EQ(table.face_count(), faces) << what;
  for (const MeshFaces::Face& face : table.faces()) {
    Key key;
    const int n = face.vertices[3] == none ? 3 : 4;
    ASSERT_TRUE(key_of({face.vertices, face.vertices + n}, key)) << what;
    auto at = wanted.find(key);
    ASSERT_TRUE(at != wanted.end() && !at->second.empty()) << what;
    auto& cells = at->second;
    const auto take = [&](std::uint32_t cell) {
      const auto place = std::find(cells.begin(), cells.end(), cell);
      ASSERT_NE(place, cells.end()) << what << ", cell " << cell;
      cells.erase(place);
    };
    take(face.cell);
    if (face.other != none)
      take(face.other);
    if (cells.empty())
      wanted.erase(at);
  }
  EXPECT_TRUE(wanted.empty()) << what;
}

Vec3d middle(const mesh::MeshView& view, std::uint32_t flat) {
  mesh::CellVertices cell;
  mesh::gather(view, flat, cell);
  return std::accumulate(cell.x, cell.x + cell.count, Vec3d{}) / double(cell.count);
}

/// Positive: in front of the triangle.
double side(const mesh::MeshView& view, const FaceTriangle& t, const Vec3d& p) {
  const auto x = [&](std::uint32_t v) { return view.pieces[0].point(v); };
  const Vec3d a = x(t.vertices[0]);
  return dot(cross(x(t.vertices[1]) - a, x(t.vertices[2]) - a), p - a);
}

/// The other order of a wedge, that of its shape functions.
TestMesh with_turned_wedges(TestMesh mesh) {
  for (test::MeshCell& cell : mesh.cells)
    if (cell.shape == mesh::Shape::wedge) {
      std::swap(cell.vertices[1], cell.vertices[2]);
      std::swap(cell.vertices[4], cell.vertices[5]);
    }
  return mesh;
}

} // namespace

TEST(MeshFaces, HasEachFaceOnceWithItsCells) {
  for (const MeshKind kind : all_kinds) {
    for (const int threads : {1, 4}) {
      const fixtures::Committed m(test::make_mesh({.kind = kind, .size = 7}, 5), threads);
      expect_faces(m.mesh.mesh().view(), m.threads, "kind " + std::to_string(int(kind)));
    }
  }
}

TEST(MeshFaces, SurvivesWhatMeshesDo) {
  test::Random random(17);
  for (const MeshKind kind : all_kinds) {
    test::OddMesh odd(test::make_mesh({.kind = kind, .size = 5}, 6), random);
    const core::Threads threads(2);
    odd.mesh.update();
    expect_faces(odd.mesh.view(), threads, "odd " + std::to_string(int(kind)));
    odd.set_ghosts();
    odd.add_piece(1); // its ids come after
    odd.mesh.update();
    expect_faces(odd.mesh.view(), threads, "ghosts, two pieces " + std::to_string(int(kind)));
  }
}

TEST(MeshFaces, IsTheSameForAnyThreadCount) {
  const fixtures::Committed m(test::make_mesh({.kind = MeshKind::mixed, .size = 20}, 7));
  core::Memory memory;
  MeshFaces one(memory), many(memory);
  one.build(m.mesh.mesh().view(), core::Threads(1));
  many.build(m.mesh.mesh().view(), core::Threads(4));
  ASSERT_EQ(one.face_count(), many.face_count());
  EXPECT_EQ(0, std::memcmp(one.faces().data(), many.faces().data(), one.faces().size_bytes()));
}

TEST(MeshFaces, CountsWhatDoesNotFit) {
  const auto table = [](const std::vector<test::MeshCell>& cells) {
    TestMesh from;
    test::Random random(1);
    for (int v = 0; v < 24; ++v)
      from.vertices.push_back(random.uniform({0, 0, 0}, {1, 1, 1}));
    from.cells = cells;
    core::Memory memory;
    mesh::Mesh mesh("fit", memory);
    const fixtures::SolverArrays arrays(from);
    const insitu_array points = arrays.point_array();
    const insitu_cells c = arrays.cells();
    mesh.set_points(0, &points, 1);
    mesh.set_cells(0, &c);
    mesh.update();
    MeshFaces faces(memory);
    faces.build(mesh.view(), core::Threads(1));
    return std::array<std::int64_t, 4>{faces.boundary_faces(), faces.crowded_faces(),
                                       faces.turned_faces(), faces.split_faces()};
  };
  using Four = std::array<std::int64_t, 4>;
  using mesh::Shape;
  const test::MeshCell hex{Shape::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7}};
  EXPECT_EQ(table({hex}), (Four{6, 0, 0, 0}));
  EXPECT_EQ(table({hex, {Shape::hexahedron, {4, 5, 6, 7, 8, 9, 10, 11}}}), (Four{10, 0, 0, 0}));
  EXPECT_EQ(table({hex, hex}), (Four{0, 0, 6, 0})) << "twice";
  EXPECT_EQ(table({hex, hex, hex}), (Four{0, 6, 6, 0})) << "three times";
  EXPECT_EQ(table({hex, {Shape::hexahedron, {4, 6, 5, 7, 8, 9, 10, 11}}}), (Four{12, 0, 0, 2}))
      << "corners in another order, counted from either side";
  for (const auto& [a, b] :
       {std::pair<std::array<int, 8>, std::array<int, 8>>{{4, 5, 6, 8}, {4, 6, 7, 8}},
        {{4, 5, 7, 8}, {5, 6, 7, 8}}})
    EXPECT_EQ(table({hex, {Shape::tetrahedron, a}, {Shape::tetrahedron, b}})[3], 1)
        << "a quad against two triangles";
}

TEST(MeshFaces, TrianglesFaceTheirCells) {
  for (const MeshKind kind : all_kinds)
    for (const bool turned : {false, true}) {
      TestMesh from = test::make_mesh({.kind = kind, .size = 5, .jitter = 0.03}, 8);
      if (turned)
        from = with_turned_wedges(from);
      const fixtures::Committed m(from);
      const mesh::MeshView& view = m.mesh.mesh().view();
      core::Memory memory;
      MeshFaces table(memory);
      table.build(view, m.threads);
      core::Buffer<FaceTriangle> triangles(memory, INSITU_MEMORY_BUILD);
      std::int64_t flat_triangles = 0, sides = 0;
      for (const MeshFaces::Face& f : table.faces()) {
        flat_triangles += f.vertices[3] == none ? 1 : 2;
        sides += (f.vertices[3] == none ? 1 : 2) * (f.other == none ? 1 : 2);
      }
      for (const Method method :
           {Method::replicated_faces, Method::shared_faces, Method::shared_bilinear_faces}) {
        table.triangles(view, m.threads, method, triangles);
        std::int64_t curved = 0;
        for (const FaceTriangle& t : triangles) {
          if (t.front != none) {
            ASSERT_GT(side(view, t, middle(view, t.front)), 0) << name(method);
          }
          if (t.back != none) {
            ASSERT_LT(side(view, t, middle(view, t.back)), 0) << name(method);
          }
          if (t.corner != none) {
            ++curved;
            ASSERT_LT(side(view, t, view.pieces[0].point(t.corner)), 0) << "out of the tetrahedron";
          }
          ASSERT_TRUE(t.back == none || method != Method::replicated_faces);
        }
        const auto count = std::int64_t(triangles.size());
        EXPECT_EQ(count, method == Method::replicated_faces ? sides : flat_triangles + curved / 2);
        const bool bends = kind != MeshKind::tetrahedra && kind != MeshKind::voxels;
        EXPECT_EQ(curved > 0, bends && method == Method::shared_bilinear_faces);
      }
    }
}

TEST(MeshFaces, KnowsTheLongestDistance) {
  TestMesh from = test::make_mesh({.kind = MeshKind::hexahedra, .size = 2, .jitter = 0}, 9);
  from.vertices.push_back({50, 0, 0}); // of no cell
  const fixtures::Committed m(from);
  const float longest = MeshFaces::longest_distance(m.mesh.mesh().view(), m.threads);
  EXPECT_GE(double(longest), std::sqrt(3.0));
  EXPECT_LE(double(longest), std::sqrt(3.0) * 1.000001);
}
