// The dual mesh that OpenFOAM's polyDualMesh makes (fixtures/poly_dual.h).
#include <map>

#include "fixtures/poly_dual.h"
#include "owners.h"

using namespace insitu;
using fixtures::CommittedFaces;
using math::Vec3d;

namespace {

double six_volumes(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return dot(b - a, cross(c - a, d - a));
}

/// A tetrahedron's, or a pyramid's, whose base is the bilinear patch: the mean over both diagonals.
double volume(const mesh::CellVertices& cell) {
  const auto& x = cell.x;
  if (cell.shape == mesh::Shape::tetrahedron)
    return six_volumes(x[0], x[1], x[2], x[3]) / 6;
  return (six_volumes(x[0], x[1], x[2], x[4]) + six_volumes(x[0], x[2], x[3], x[4]) +
          six_volumes(x[0], x[1], x[3], x[4]) + six_volumes(x[1], x[2], x[3], x[4])) /
         12;
}

} // namespace

TEST(PolyDualMesh, PointsAreOwnedOnceAndTheCubeIsFilled) {
  const CommittedFaces m(fixtures::poly_dual());
  ASSERT_EQ(m.mesh.mesh().own_view().cell_count(), 64);
  fixtures::expect_filled(m, {0, 0, 0}, {3, 3, 3}, 400, 31);
  fixtures::expect_one_owner(m);
}

/// The parts fill the cube, of volume 27, and what they do not share is its surface, of area 54.
/// Coordinates are of 9 digits, sums of some thousand terms of up to 1.
TEST(PolyDualMesh, VolumesAndTheBoundarysAreasAddUp) {
  const CommittedFaces m(fixtures::poly_dual());
  const mesh::MeshView& view = m.mesh.mesh().view();
  double sum = 0;
  std::map<std::vector<std::int64_t>, std::pair<int, double>> faces; // how often, and the area
  for (std::int64_t c = 0; c < view.cell_count(); ++c) {
    mesh::CellVertices cell;
    mesh::gather(view, c, cell);
    ASSERT_TRUE(cell.shape == mesh::Shape::tetrahedron || cell.shape == mesh::Shape::pyramid);
    ASSERT_GT(volume(cell), 0);
    sum += volume(cell);
    const cells::FaceTable table = cells::face_table(cell.shape);
    for (int f = 0; f < table.face_count; ++f) {
      std::vector<Vec3d> ring;
      std::vector<std::int64_t> key;
      for (int v = 0; v < table.faces[f].vertex_count; ++v)
        ring.push_back(cell.x[table.faces[f].vertices[v]]);
      for (const Vec3d& x : ring) // by its places, to a billionth
        for (int a = 0; a < 3; ++a)
          key.push_back(std::llround(x[a] * 1e9));
      std::vector<std::array<std::int64_t, 3>> corners;
      for (std::size_t k = 0; k < key.size(); k += 3)
        corners.push_back({key[k], key[k + 1], key[k + 2]});
      std::ranges::sort(corners);
      key.clear();
      for (const auto& corner : corners)
        key.insert(key.end(), corner.begin(), corner.end());
      Vec3d twice{};
      for (std::size_t k = 2; k < ring.size(); ++k)
        twice += cross(ring[k - 1] - ring[0], ring[k] - ring[0]);
      auto& [count, area] = faces[key];
      ++count;
      area = std::sqrt(dot(twice, twice)) / 2;
    }
  }
  EXPECT_NEAR(sum, 27, 1e-7);
  double surface = 0;
  for (const auto& [key, face] : faces) {
    ASSERT_LE(face.first, 2);
    if (face.first == 2)
      continue;
    surface += face.second;
    bool on_a_side = false;
    for (std::size_t a = 0; a < 3; ++a)
      for (const std::int64_t side : {0LL, 3000000000LL}) {
        bool all = true;
        for (std::size_t k = a; k < key.size(); k += 3)
          all = all && std::abs(key[k] - side) <= 2;
        on_a_side = on_a_side || all;
      }
    EXPECT_TRUE(on_a_side);
  }
  EXPECT_NEAR(surface, 54, 1e-7);
}
