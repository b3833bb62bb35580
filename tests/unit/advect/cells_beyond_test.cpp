// Guesses at the cells beyond faces, by numbers and by a table of neighbours.
#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "box_mesh.h"
#include "lane_runs.h"

namespace insitu::test {
namespace {

/// The cell that holds a point beyond the middle of each side, as the sampler says.
TEST(CellsBeyond, StepsOfRowsAreLearnt) {
  constexpr std::int64_t n = 7;
  BoxMesh box(n, -1.0, 1.0);
  const advect::CellsBeyond beyond(box.sampler());
  ASSERT_TRUE(beyond.knows());
  const mesh::Shape hexahedron = mesh::Shape::hexahedron;
  const std::int64_t cell = 3 + n * (3 + n * 3), steps[3] = {1, n, n * n};
  for (int a = 0; a < 3; ++a)
    for (const double sign : {-1.0, 1.0}) {
      Vec3d r{0.5, 0.5, 0.5};
      r[a] += 0.6 * sign;
      EXPECT_EQ(beyond.guess(cell, hexahedron, r), cell + std::int64_t(sign) * steps[a]);
      r[(a + 1) % 3] = -0.1; // across an edge
      EXPECT_EQ(beyond.guess(cell, hexahedron, r),
                cell + std::int64_t(sign) * steps[a] - steps[(a + 1) % 3]);
    }
  EXPECT_EQ(beyond.guess(cell, hexahedron, {0.5, 0.5, 0.5}), -1) << "inside";
  EXPECT_EQ(beyond.guess(cell, hexahedron, {0.5, 0.5, 1.0 - 1e-9}, 1e-6), cell + n * n)
      << "on a face";
  EXPECT_EQ(beyond.guess(cell, mesh::Shape::tetrahedron, {-0.5, 0.5, 0.5}), -1) << "no steps";
}

/// Beyond each face, and this near to it, the neighbour; outside nothing.
TEST(CellsBeyond, NeighboursAreThoseAcrossTheFaces) {
  for (const MeshKind kind : all_kinds) {
    SCOPED_TRACE(int(kind));
    TestMesh from = mesh_of(kind, 4);
    std::shuffle(from.cells.begin(), from.cells.end(), std::mt19937(7));
    Swirling mesh(from);
    mesh.m.mesh.find_neighbours(mesh.m.threads);
    const query::Sampler sampler = mesh.sampler();
    const advect::CellsBeyond beyond(sampler);
    std::int64_t wrong = 0, outside = 0, inside = 0;
    for (std::int64_t cell = 0; cell < sampler.mesh().cell_count(); ++cell) {
      mesh::CellVertices c;
      mesh::gather(sampler.mesh(), cell, c);
      const cells::FaceTable table = cells::face_table(c.shape);
      Vec3d centre;
      for (int v = 0; v < c.count; ++v)
        centre += c.x[v] / double(c.count);
      for (int f = 0; f < table.face_count; ++f) {
        const int n = table.faces[f].vertex_count;
        Vec3d middle;
        for (int k = 0; k < n; ++k)
          middle += c.x[table.faces[f].vertices[k]] / double(n);
        for (const double part : {1e-3, -1e-9}) {
          const Vec3d x = middle + part * (middle - centre);
          const auto map = cells::inverse_map(c.shape, c.x, x);
          const query::Location at = sampler.locate(middle + 1e-3 * (middle - centre));
          const std::int64_t guess = beyond.guess(cell, c.shape, map.r, part > 0.0 ? 0.0 : 1e-6);
          wrong += guess != at.cell;
          outside += !at;
          inside += bool(at);
        }
      }
      const auto map = cells::inverse_map(c.shape, c.x, centre);
      wrong += beyond.guess(cell, c.shape, map.r) != -1;
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(outside, 0);
    EXPECT_GT(inside, 0);
  }
}

/// Made once the tree was asked for want of it often enough, and kept until the cells are others;
/// where numbers tell, never.
TEST(CellsBeyond, NeighboursAreFoundWhenTheyAreDue) {
  for (const bool by_number : {false, true}) {
    Swirling mesh(mesh_of(by_number ? MeshKind::hexahedra : MeshKind::tetrahedra, 5));
    commit::CommittedMesh& of = mesh.m.mesh;
    const mesh::FieldView field = mesh.field();
    const IntegratorSettings settings;
    const auto go = [&] {
      const advect::CellsBeyond beyond(mesh.sampler());
      EXPECT_EQ(beyond.lacks_neighbours(), !by_number && !of.neighbours());
      in_lanes(mesh.sampler(), {field}, settings, seeds(), 0.1, &beyond);
    };
    int rounds = 0;
    const auto until_due = [&] {
      for (rounds = 0; rounds < 200 && !of.neighbours(); ++rounds) {
        go();
        of.find_neighbours_if_due(mesh.m.threads);
      }
    };
    until_due();
    EXPECT_EQ(of.neighbours() != nullptr, !by_number);
    EXPECT_GT(rounds, 1) << "not at once";
    const accel::FaceNeighbours* const table = of.neighbours();
    mesh.m.commit(INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS);
    EXPECT_EQ(of.neighbours(), table) << "the cells are the same";
    mesh.m.commit(INSITU_CHANGED_TOPOLOGY);
    EXPECT_EQ(of.neighbours(), nullptr);
    of.find_neighbours_if_due(mesh.m.threads);
    EXPECT_EQ(of.neighbours(), nullptr) << "counted anew";
  }
}

/// Cells that are numbered at random have no steps, and nothing is guessed.
TEST(CellsBeyond, ShuffledNumbersTellNothing) {
  Random random(8);
  TestMesh mesh = make_mesh({.kind = MeshKind::hexahedra, .size = 8, .jitter = 0.1}, random);
  const auto knows = [](const TestMesh& m) {
    fixtures::Committed committed(m);
    committed.mesh.look_for_folds(committed.threads);
    return advect::CellsBeyond(committed.sampler()).knows();
  };
  EXPECT_TRUE(knows(mesh));
  std::shuffle(mesh.cells.begin(), mesh.cells.end(), std::mt19937(3));
  EXPECT_FALSE(knows(mesh));
}

} // namespace
} // namespace insitu::test
