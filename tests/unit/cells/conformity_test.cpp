/// What does not conform is counted, and every point has the documented owner all the same.

#include <gtest/gtest.h>

#include "cells/checks/conformity.h"
#include "cells/exact/contain_exact.h"
#include "fixtures/committed.h"

using namespace insitu;
using math::Vec3d;
using mesh::Shape;

namespace {

insitu_validation counts(const test::TestMesh& mesh) {
  fixtures::Committed m(mesh);
  return m.mesh.validate(m.threads).counts;
}

struct Odd {
  std::int64_t coincident, crowded, split;
  bool operator==(const Odd&) const = default;
};
std::ostream& operator<<(std::ostream& out, const Odd& o) {
  return out << o.coincident << " coincident, " << o.crowded << " crowded, " << o.split << " split";
}
Odd odd(const test::TestMesh& mesh) {
  const insitu_validation c = counts(mesh);
  return {c.coincident_vertices, c.crowded_faces, c.split_faces};
}

/// A twisted quad on top of one hexahedron, and nothing above it yet.
test::TestMesh twisted_hexahedron() {
  test::TestMesh mesh;
  const test::Vertices v = test::unit_cell(Shape::hexahedron);
  mesh.vertices.assign(v.begin(), v.end());
  mesh.vertices[6].z = 1.25;
  mesh.vertices[4].z = 1.125;
  mesh.cells.push_back({Shape::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7}});
  return mesh;
}

/// Owners by exact containment one cell at a time, and by the library.
void expect_lowest_holder(const test::TestMesh& mesh, std::uint64_t seed, int& none, int& several) {
  fixtures::Committed m(mesh);
  test::Random random(seed);
  for (int i = 0; i < 4000; ++i) {
    const Vec3d p = random.uniform({-0.1, -0.1, 0.8}, {1.1, 1.1, 1.5});
    std::int64_t lowest = -1;
    int holders = 0;
    const auto holds = [&](std::int64_t cell) {
      const test::MeshCell& c = mesh.cells[std::size_t(cell)];
      return cells::holds(cells::contain_exact(c.shape, mesh.cell_vertices(c).data(), p).where);
    };
    for (auto c = std::int64_t(mesh.cells.size()); c-- > 0;)
      if (holds(c)) {
        lowest = c;
        ++holders;
      }
    query::LocateOptions options;
    options.accuracy = INSITU_EXACT;
    ASSERT_EQ(m.sampler().locate(p, -1, options).cell, lowest) << "seed " << seed << ", " << i;
    // Of several that overlap, standard may answer any.
    options.accuracy = INSITU_STANDARD;
    const std::int64_t any = m.sampler().locate(p, -1, options).cell;
    ASSERT_TRUE(any == lowest || (holders > 1 && any >= 0 && holds(any)))
        << "seed " << seed << ", " << i << ": cell " << any << ", lowest " << lowest;
    const bool covered = // whatever stands on the hexahedron
        std::fabs(p.x - 0.5) < 0.2 && std::fabs(p.y - 0.5) < 0.2 && p.z < 1.3;
    none += covered && holders == 0;
    several += holders > 1;
  }
}

} // namespace

TEST(Conformity, ConformingMeshesHaveNothingOdd) {
  for (int kind = 0; kind < 6; ++kind) {
    test::Random random(911);
    test::MeshOptions options;
    options.kind = test::MeshKind(kind);
    EXPECT_EQ(odd(test::make_mesh(options, random)), (Odd{0, 0, 0})) << kind;
  }
}

/// Vertices kept twice along a seam: faces meet by place, and every point of the seam has one
/// owner.
TEST(Conformity, SeamsAreCountedAndHarmless) {
  test::Random random(912);
  test::TestMesh mesh = test::make_mesh({.size = 3}, random);
  const auto before = mesh.vertices.size();
  std::vector<int> copy(before, -1);
  for (std::size_t c = mesh.cells.size() / 3; c < mesh.cells.size(); ++c)
    for (int& v : mesh.cells[c].vertices) {
      if (copy[std::size_t(v)] < 0) {
        copy[std::size_t(v)] = int(mesh.vertices.size());
        mesh.vertices.push_back(mesh.vertices[std::size_t(v)]);
      }
      v = copy[std::size_t(v)];
    }
  EXPECT_EQ(odd(mesh), (Odd{16, 0, 0})); // the 4 x 4 vertices of one layer
  fixtures::Committed m(mesh);
  for (std::size_t v = 0; v < before; ++v)
    EXPECT_TRUE(m.sampler().locate(mesh.vertices[v]));
}

/// Minus zero and zero are one place.
TEST(Conformity, PlacesAreCoordinates) {
  test::TestMesh mesh = twisted_hexahedron();
  for (int k = 0; k < 8; ++k) {
    Vec3d p = mesh.vertices[std::size_t(k)];
    mesh.vertices.push_back({-p.x, p.y, p.z});
  }
  mesh.cells.push_back({Shape::hexahedron, {9, 8, 11, 10, 13, 12, 15, 14}});
  EXPECT_EQ(odd(mesh), (Odd{4, 0, 0}));
}

TEST(Conformity, AQuadAgainstTwoTriangles) {
  for (const bool other_diagonal : {false, true}) {
    test::TestMesh mesh = twisted_hexahedron();
    mesh.vertices.push_back({0.5, 0.5, 2});
    if (other_diagonal) {
      mesh.cells.push_back({Shape::tetrahedron, {5, 6, 7, 8}});
      mesh.cells.push_back({Shape::tetrahedron, {5, 7, 4, 8}});
    } else {
      mesh.cells.push_back({Shape::tetrahedron, {4, 5, 6, 8}});
      mesh.cells.push_back({Shape::tetrahedron, {4, 6, 7, 8}});
    }
    EXPECT_EQ(odd(mesh), (Odd{0, 0, 1}));
    int none = 0, several = 0;
    expect_lowest_holder(mesh, 913, none, several);
    // The vertices 4 and 6 are lifted: their triangles lie above the patch, the others' below.
    EXPECT_GT(other_diagonal ? several : none, 0);
    EXPECT_EQ(other_diagonal ? none : several, 0);
  }
}

TEST(Conformity, ThePyramidOverAQuadMatchesIt) {
  test::TestMesh mesh = twisted_hexahedron();
  mesh.vertices.push_back({0.5, 0.5, 2});
  mesh.cells.push_back({Shape::pyramid, {4, 5, 6, 7, 8}});
  EXPECT_EQ(odd(mesh), (Odd{0, 0, 0}));
}

TEST(Conformity, AQuadAgainstTheSameCornersInAnotherOrder) {
  test::TestMesh mesh = twisted_hexahedron();
  mesh.vertices.push_back({0.5, 0.5, 2});
  mesh.cells.push_back({Shape::pyramid, {4, 6, 5, 7, 8}});
  EXPECT_EQ(odd(mesh), (Odd{0, 0, 1}));
}

TEST(Conformity, AFaceOfThreeCells) {
  test::TestMesh mesh = twisted_hexahedron();
  mesh.vertices.push_back({0.5, 0.5, 2});
  mesh.vertices.push_back({0.4, 0.5, 1.9});
  mesh.cells.push_back({Shape::pyramid, {4, 5, 6, 7, 8}});
  mesh.cells.push_back({Shape::pyramid, {4, 5, 6, 7, 9}});
  EXPECT_EQ(odd(mesh), (Odd{0, 1, 0}));
  int none = 0, several = 0;
  expect_lowest_holder(mesh, 914, none, several);
  EXPECT_GT(several, 0);
}

/// A quad that lost a corner is the triangle that is left, to its neighbours as well.
TEST(Conformity, CollapsedHexahedraMatchWhatIsLeft) {
  test::TestMesh mesh;
  const test::Vertices v = test::unit_cell(Shape::wedge);
  mesh.vertices.assign(v.begin(), v.begin() + 6);
  mesh.vertices.push_back({0.2, 0.2, 2});
  mesh.cells.push_back({Shape::hexahedron, {0, 1, 2, 2, 3, 4, 5, 5}});
  mesh.cells.push_back({Shape::tetrahedron, {3, 5, 4, 6}});
  EXPECT_EQ(odd(mesh), (Odd{0, 0, 0}));
  mesh.cells.push_back({Shape::tetrahedron, {3, 4, 5, 6}});
  EXPECT_EQ(odd(mesh), (Odd{0, 1, 0})) << "a second one on the same face";
}
