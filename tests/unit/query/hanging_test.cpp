// Vertices that touch a cell which has no corner there are counted.
#include "commit/checks/hanging_vertices.h"
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::all_kinds;
using test::box;

namespace {

struct Counts {
  std::int64_t hanging, covered;
  bool operator==(const Counts&) const = default;
};
std::ostream& operator<<(std::ostream& out, const Counts& c) {
  return out << c.hanging << " hanging, " << c.covered << " covered";
}

Counts counts(const test::TestMesh& mesh, int threads = 1) {
  fixtures::Committed m(mesh, threads);
  const insitu_validation c = m.mesh.validate(m.threads).counts;
  return {c.hanging_vertices, c.covered_vertices};
}

/// One hexahedron, bent at x = 1 by `bend`, and beyond it n^3 of its size whose corners lie on its
/// face as the bilinear patch has them.
test::TestMesh coarse_beside_fine(int n, double bend, const Vec3d& offset) {
  test::TestMesh mesh;
  const auto face = [&](double s, double t) { return 1 + bend * s * t; };
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i)
        mesh.vertices.push_back(offset + Vec3d{i ? face(j, k) : 0.0, double(j), double(k)});
  mesh.cells.push_back({mesh::Shape::hexahedron, {0, 1, 3, 2, 4, 5, 7, 6}});
  const auto id = [&](int i, int j, int k) {
    if (i == 0 && j % n == 0 && k % n == 0) // the coarse cell's own
      return 1 + 2 * (j / n) + 4 * (k / n);
    return 8 + i + (n + 1) * (j + (n + 1) * k);
  };
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double s = double(j) / n, t = double(k) / n;
        mesh.vertices.push_back(offset + Vec3d{face(s, t) + double(i) / n, s, t});
      }
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        mesh.cells.push_back(
            {mesh::Shape::hexahedron,
             {id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k), id(i, j, k + 1),
              id(i + 1, j, k + 1), id(i + 1, j + 1, k + 1), id(i, j + 1, k + 1)}});
  return mesh;
}

} // namespace

TEST(Hanging, NoneWhereCellsFit) {
  for (const auto kind : all_kinds)
    for (const double offset : {0.0, 1e7})
      for (const int threads : {1, 4})
        EXPECT_EQ(counts(box(kind, 6, 0.2, offset), threads), (Counts{0, 0})) << kind_name(kind);
  EXPECT_EQ(counts(box(test::MeshKind::mixed, 6, 0.2, 0, {1, 1, 1e-6})), (Counts{0, 0}));
}

TEST(Hanging, OnTheFaceOfACoarserCell) {
  for (const int n : {2, 3, 8})
    for (const double bend : {0.0, 0.25})
      for (const Vec3d& offset : {Vec3d{0, 0, 0}, Vec3d{1e5, -1e5, 3e5}})
        EXPECT_EQ(counts(coarse_beside_fine(n, bend, offset)), (Counts{(n + 1) * (n + 1) - 4, 0}))
            << n << ", " << bend << ", " << test::text(offset);
}

TEST(Hanging, OnAnEdge) {
  test::TestMesh mesh = coarse_beside_fine(1, 0.0, {0, 0, 0});
  // A tetrahedron that touches the first cell with one corner, in the middle of an edge.
  const auto v = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{0, 0.5, 0}, {-1, 0.5, 0}, {-1, 1, 0}, {-1, 0.5, -1}});
  mesh.cells.push_back({mesh::Shape::tetrahedron, {v, v + 2, v + 1, v + 3}});
  EXPECT_EQ(counts(mesh), (Counts{1, 0}));
}

TEST(Hanging, InsideOverlappingCells) {
  const test::TestMesh one = box(test::MeshKind::hexahedra, 4, 0.0);
  test::TestMesh mesh = one;
  const auto vertices = int(one.vertices.size());
  for (const Vec3d& v : one.vertices)
    mesh.vertices.push_back(v + Vec3d{0.5, 0.25, 0.125});
  for (test::MeshCell c : one.cells) {
    for (int& v : c.vertices)
      v += vertices;
    mesh.cells.push_back(c);
  }
  // Of 5^3 corners of either box 4^3 lie in the other.
  EXPECT_EQ(counts(mesh), (Counts{0, 2 * 64}));
  fixtures::Committed m(mesh);
  std::vector<std::uint8_t> ghosts(mesh.cells.size(), 0);
  std::fill(ghosts.begin(), ghosts.begin() + std::int64_t(one.cells.size()), std::uint8_t(1));
  const insitu_array bits =
      insitu_array_of(ghosts.data(), INSITU_UINT8, std::int64_t(ghosts.size()), 1);
  m.mesh.mesh().set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
  EXPECT_EQ(m.mesh.validate(m.threads).counts.covered_vertices, 0) << "ghosts own nothing";
}
