#pragma once

#include <atomic>
#include <cmath>
#include <functional>
#include <latch>
#include <thread>
#include <utility>

#include "mesh/box.h"
#include "mesh/piece_borders.h"
#include "query/batch/guessed_batches.h"
#include "query/on_demand.h"
#include "query_test.h"

/// What the tests of cells that are alone share: meshes that overlap themselves, and brute force.
namespace insitu::test {

inline constexpr double pi = 3.14159265358979323846;

/// All cells the right way round; the fixtures' tetrahedra are mirrored by halves.
inline TestMesh upright(TestMesh mesh) {
  for (auto& cell : mesh.cells) {
    const auto x = mesh.cell_vertices(cell);
    if (cell.shape == mesh::Shape::tetrahedron &&
        dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) < 0)
      std::swap(cell.vertices[2], cell.vertices[3]);
  }
  return mesh;
}

using Map = std::function<Vec3d(const Vec3d&)>;

inline TestMesh moved(TestMesh mesh, const Map& to) {
  for (Vec3d& v : mesh.vertices)
    v = to(v);
  return mesh;
}

/// Adds the other mesh's vertices and cells, which stay apart from those that are there.
inline void add(TestMesh& mesh, const TestMesh& other) {
  const int first = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (test::MeshCell cell : other.cells) {
    for (int v = 0; v < mesh::vertex_count(cell.shape); ++v)
      cell.vertices[std::size_t(v)] += first;
    mesh.cells.push_back(cell);
  }
}

/// The place in the box as parts of its edges.
inline Vec3d parts(const TestMesh& mesh, const Vec3d& p) {
  Vec3d part;
  for (int a = 0; a < 3; ++a)
    part[a] = (p[a] - mesh.low[a]) / (mesh.high[a] - mesh.low[a]);
  return part;
}

/// A band that is wound so many times round an axis, all turns at the same place.
inline TestMesh wound(const TestMesh& from, double turns) {
  return moved(from, [&](const Vec3d& p) {
    const Vec3d at = parts(from, p);
    const double angle = -2 * pi * turns * at.x, radius = 1.0 + at.y;
    return Vec3d{radius * std::cos(angle), radius * std::sin(angle), at.z};
  });
}

inline const query::LoneCells& lone_cells(const fixtures::Committed& m) {
  return *m.sampler().on_demand()->lone;
}

/// So many cells are found to be alone; 0 where none is known.
inline std::int64_t find(const fixtures::Committed& m) {
  const query::LoneCells& lone = lone_cells(m);
  const mesh::MeshView& view = m.mesh.mesh().view();
  m.sampler().tree();
  lone.find(view, m.threads);
  std::int64_t count = 0;
  for (std::int64_t c = 0; c < view.cell_count() && lone.are_known(); ++c)
    count += lone.has(c);
  return count;
}

/// By the definition: the lowest of the owning cells that hold the point, and how many there are.
struct Holding {
  std::int64_t lowest = -1, count = 0;
};
inline Holding cells_that_hold(const mesh::MeshView& view, const Vec3d& p) {
  Holding found;
  for (std::int64_t c = 0; c < view.cell_count(); ++c) {
    const std::int32_t piece = view.piece_of(c);
    if (!view.pieces[piece].owns(c - view.first_cell[piece]))
      continue;
    mesh::CellVertices cell;
    mesh::gather(view, c, cell);
    if (!mesh::box_of(cell).holds(p) ||
        !cells::holds(cells::contain_exact(cell.shape, cell.x, p).where))
      continue;
    found.lowest = found.count++ == 0 ? c : found.lowest;
  }
  return found;
}

/// Finds the cells that are alone, and holds them against all cells: a point within one is in no
/// other. `exact` then names the lowest id, in batches and one by one. Returns how many are alone.
inline std::int64_t check(const fixtures::Committed& m, const std::string& what, int count = 300,
                          std::uint64_t seed = 17) {
  const std::int64_t alone = find(m);
  const mesh::MeshView& view = m.mesh.mesh().view();
  const query::LoneCells& lone = lone_cells(m);
  std::vector<Vec3d> points = test::inner_points(view, count, seed);
  const std::vector<Vec3d> hard = test::hard_points(view, count / 3, seed + 1);
  points.insert(points.end(), hard.begin(), hard.end());
  std::vector<query::Location> batch(points.size());
  m.sampler().locate(m.threads, points, batch, {INSITU_EXACT, 1.0});
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::int64_t want = cells_that_hold(view, points[i]).lowest;
    EXPECT_EQ(batch[i].cell, want) << what << ", point " << test::text(points[i]);
    const query::Location one = m.sampler().locate(points[i], -1, {INSITU_EXACT, 1.0});
    EXPECT_TRUE(test::same_bits(one, batch[i])) << what << ", point " << test::text(points[i]);
    if (testing::Test::HasFailure())
      return alone;
  }
  test::Random random(seed);
  const std::int64_t cells = view.cell_count(), step = std::max<std::int64_t>(1, alone / count);
  std::int64_t turn = 0;
  for (std::int64_t c = 0; c < cells && alone > 0; ++c) {
    if (!lone.has(c) || ++turn % step != 0)
      continue;
    mesh::CellVertices cell;
    mesh::gather(view, c, cell);
    const Vec3d p = cells::map_to_physical(
        cell.shape, cell.x, fixtures::random_parametric(cell.shape, seed, std::uint64_t(c)));
    if (!cells::holds(cells::contain_exact(cell.shape, cell.x, p).where))
      continue; // by rounding
    EXPECT_EQ(cells_that_hold(view, p).count, 1)
        << what << ", cell " << c << " is not alone at " << test::text(p);
    if (testing::Test::HasFailure())
      return alone;
  }
  return alone;
}

inline double share(const fixtures::Committed& m, std::int64_t count) {
  return double(count) / double(m.mesh.mesh().view().cell_count());
}

} // namespace insitu::test
