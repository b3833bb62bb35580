// What holds of the owners of points on cells given by faces.
#pragma once

#include <cstdlib>

#include "../query/query_test.h"
#include "fixtures/polyhedra.h"

namespace insitu::fixtures {

/// The lowest solver's cell that holds a point, by the parts one by one.
inline std::int64_t lowest_cell(const CommittedFaces& m, const Vec3d& p) {
  const std::int64_t part = test::owner(m.mesh.mesh().view(), p);
  return part < 0 ? -1 : m.mesh.stand_in()->place(part).own;
}

inline void expect_owners(const CommittedFaces& m, const std::vector<Vec3d>& points) {
  const mesh::MeshView& view = m.mesh.mesh().view();
  for (const insitu_accuracy accuracy : {INSITU_STANDARD, INSITU_EXACT}) {
    std::vector<query::Location> batch(points.size());
    m.sampler().locate(m.threads, points, batch, {accuracy, 1.0});
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(batch[i].cell, test::owner(view, points[i])) << test::text(points[i]);
      ASSERT_EQ(m.mesh.own(batch[i], points[i]).cell, lowest_cell(m, points[i]));
    }
  }
}

/// Owners of points of all sorts are those of the definition, and the box from `low` to `high`,
/// which lies in the mesh, is filled: what is not in a cell would be found in none.
inline void expect_filled(const CommittedFaces& m, const Vec3d& low, const Vec3d& high, int hard,
                          std::uint64_t seed) {
  EXPECT_TRUE(m.warnings.empty()) << m.warnings[0];
  const mesh::MeshView& view = m.mesh.mesh().view();
  expect_owners(m, test::hard_points(view, hard, seed));
  expect_owners(m, test::inner_points(view, hard / 2, seed + 1));
  test::Random random(seed + 2);
  for (int i = 0; i < 4000; ++i)
    ASSERT_GE(m.owner(random.uniform(low, high)), 0);
}

/// Points on faces, edges and vertices have the owner that all parts one by one tell.
/// INSITU_TEST_POINTS: so many.
inline void expect_one_owner(const CommittedFaces& m) {
  const char* const asked = std::getenv("INSITU_TEST_POINTS");
  const int count = asked ? std::atoi(asked) : 20000;
  const mesh::MeshView& view = m.mesh.mesh().view();
  std::vector<mesh::Box> boxes;
  std::vector<mesh::CellVertices> cells(std::size_t(view.cell_count()));
  for (std::size_t c = 0; c < cells.size(); ++c) {
    mesh::gather(view, std::int64_t(c), cells[c]);
    boxes.push_back(mesh::box_of(cells[c]));
  }
  const auto lowest = [&](const Vec3d& p) -> std::int64_t {
    for (std::size_t c = 0; c < cells.size(); ++c)
      if (boxes[c].holds(p) &&
          cells::holds(cells::contain_exact(cells[c].shape, cells[c].x, p).where))
        return std::int64_t(c);
    return -1;
  };
  const int at_once = std::min(count, 100000);
  std::vector<query::Location> batch(static_cast<std::size_t>(at_once));
  for (int first = 0; first < count / 2; first += at_once) {
    const std::vector<Vec3d> points = test::hard_points(view, at_once, 15 + std::uint64_t(first));
    m.sampler().locate(m.threads, points, batch, {INSITU_EXACT, 1.0});
    for (std::size_t i = 0; i < points.size(); ++i)
      ASSERT_EQ(batch[i].cell, lowest(points[i]))
          << "seed " << 15 + first << " " << test::text(points[i]);
  }
}

} // namespace insitu::fixtures
