// What is asked of a mesh as a whole: exact bounds and sizes, in parts and in any order.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <vector>

#include "mesh/facts.h"
#include "mesh/ghosts.h"
#include "numerics/exact/cases.h"

using namespace insitu;
using math::Vec3d;
using mesh::MeshFacts;

namespace {

/// Hexahedra in the shape of boxes, each with eight vertices of its own.
struct Boxes {
  std::vector<Vec3d> points;
  std::vector<std::int64_t> ids;
  std::vector<std::uint8_t> ghosts;
  mesh::PieceView piece;
  std::int64_t first_cell[2] = {0, 0}, first_vertex[2] = {0, 0};
  mesh::MeshView mesh;

  void add(const Vec3d& low, const Vec3d& size, bool ghost = false) {
    constexpr int corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                  {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    for (const auto& c : corner) {
      ids.push_back(std::int64_t(points.size()));
      points.push_back({low.x + c[0] * size.x, low.y + c[1] * size.y, low.z + c[2] * size.z});
    }
    ghosts.push_back(ghost);
  }

  const mesh::MeshView& view() {
    piece = {};
    piece.layout = mesh::CellLayout::uniform;
    piece.uniform_shape = mesh::Shape::hexahedron;
    piece.cell_count = std::int64_t(ghosts.size());
    piece.vertex_count = std::int64_t(points.size());
    piece.connectivity = {reinterpret_cast<const std::byte*>(ids.data()), std::int64_t(ids.size()),
                          64, false};
    piece.id_stride = 8;
    for (int a = 0; a < 3; ++a)
      piece.points.component[a] = reinterpret_cast<const std::byte*>(points.data()) + 8 * a;
    piece.points.layout = {piece.vertex_count, {piece.vertex_count, 1}, {24, 0, 0}, true};
    mesh::set_ghosts(piece, ghosts.data(), 1);
    first_cell[1] = piece.cell_count;
    first_vertex[1] = piece.vertex_count;
    mesh = {};
    mesh.pieces = &piece;
    mesh.first_cell = first_cell;
    mesh.first_vertex = first_vertex;
    mesh.piece_count = 1;
    return mesh;
  }
};

bool same(const MeshFacts& a, const MeshFacts& b) {
  return a.cells == b.cells && a.bounds.low == b.bounds.low && a.bounds.high == b.bounds.high &&
         std::ranges::equal(a.sizes, b.sizes, [](const auto& x, const auto& y) {
           return x.key == y.key && x.cells == y.cells && x.least == y.least;
         });
}

TEST(MeshFacts, BoundsAreThoseOfOwnedCellsToTheBit) {
  Boxes boxes;
  boxes.add({0.1, -1e300, 3}, {0.2, 1, 1e-9});
  boxes.add({-7, 0, 0}, {1, 1, 1});
  boxes.add({100, 100, 100}, {1, 1, 1}, true);
  const MeshFacts facts = mesh::find_facts(boxes.view(), nullptr);
  EXPECT_EQ(facts.cells, 2);
  EXPECT_EQ(facts.bounds.low, (Vec3d{-7, -1e300, 0}));
  EXPECT_EQ(facts.bounds.high, (Vec3d{0.1 + 0.2, 1, 3 + 1e-9}));
}

TEST(MeshFacts, TheSizeIsTheMediansWithinTheClass) {
  Boxes boxes;
  for (int i = 0; i < 3; ++i)
    boxes.add({double(i), 0, 0}, {1e-3, 1e-3, 1e-3});
  for (int i = 0; i < 5; ++i)
    boxes.add({double(i), 1, 0}, {0.5, 0.5, 0.5});
  EXPECT_DOUBLE_EQ(mesh::find_facts(boxes.view(), nullptr).cell_size(), 0.5);
}

TEST(MeshFacts, NoCellsAndFlatCells) {
  Boxes none;
  const MeshFacts facts = mesh::find_facts(none.view(), nullptr);
  EXPECT_EQ(facts.diagonal(), 1.0);
  EXPECT_EQ(facts.cell_size(), 1.0);
  Boxes flat;
  flat.add({0, 0, 0}, {3, 4, 0});
  EXPECT_EQ(mesh::find_facts(flat.view(), nullptr).diagonal(), 5.0);
  EXPECT_DOUBLE_EQ(mesh::find_facts(flat.view(), nullptr).cell_size(), 5.0 / 256);
  Boxes point;
  point.add({1, 1, 1}, {0, 0, 0});
  EXPECT_EQ(mesh::find_facts(point.view(), nullptr).diagonal(), 1.0);
}

/// Parts of a mesh in any order, and any number of threads, give the bits of the whole.
TEST(MeshFacts, PartsAddUpInAnyOrder) {
  constexpr std::uint64_t seed = 17;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  Boxes whole, parts[3];
  for (int i = 0; i < 70000; ++i) {
    const Vec3d low = random.uniform({-1, -2, -3}, {5, 6, 7});
    const double scale = std::exp2(random.uniform(-30.0, 2.0));
    const Vec3d size = scale * random.uniform({0.1, 0.1, 0.1}, {1, 1, 1});
    const bool ghost = i % 11 == 0;
    whole.add(low, size, ghost);
    parts[i % 3].add(low, size, ghost);
  }
  const core::Threads threads(2);
  const MeshFacts expected = mesh::find_facts(whole.view(), nullptr);
  EXPECT_TRUE(same(mesh::find_facts(whole.view(), &threads), expected));
  int order[] = {0, 1, 2};
  do {
    MeshFacts sum;
    for (const int i : order)
      sum.add(mesh::find_facts(parts[i].view(), nullptr));
    EXPECT_TRUE(same(sum, expected));
    EXPECT_EQ(sum.cell_size(), expected.cell_size());
  } while (std::next_permutation(order, order + 3));
}

} // namespace
