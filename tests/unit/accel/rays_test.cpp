// A walk along a ray visits every cell that the ray meets.
#include <gtest/gtest.h>

#include "accel/camera_rays/ray_traversal.h"
#include "fixtures/committed.h"
#include "fixtures/simd_targets.h"

using namespace insitu;
using math::Vec3d;

namespace {

/// Whether the ray surely meets the box of the cell's vertices: by slabs in long double.
bool meets_box(const mesh::CellVertices& cell, const Vec3d& origin, const Vec3d& direction,
               double t_min, double t_max) {
  long double near = t_min, far = t_max;
  for (int a = 0; a < 3; ++a) {
    long double lo = cell.x[0][a], hi = lo;
    for (int v = 1; v < cell.count; ++v) {
      lo = std::min<long double>(lo, cell.x[v][a]);
      hi = std::max<long double>(hi, cell.x[v][a]);
    }
    if (direction[a] == 0.0) {
      if (lo > origin[a] || hi < origin[a])
        return false;
      continue;
    }
    long double t0 = (lo - origin[a]) / direction[a], t1 = (hi - origin[a]) / direction[a];
    if (t0 > t1)
      std::swap(t0, t1);
    near = std::max(near, t0);
    far = std::min(far, t1);
  }
  return near <= far;
}

struct Walk {
  const fixtures::Committed& m;
  std::vector<mesh::CellVertices> cells;

  explicit Walk(const fixtures::Committed& mesh)
      : m(mesh), cells(std::size_t(mesh.mesh.mesh().view().cell_count())) {
    for (std::size_t c = 0; c < cells.size(); ++c)
      mesh::gather(m.mesh.mesh().view(), std::int64_t(c), cells[c]);
  }

  std::vector<int> visits(const Vec3d& origin, const Vec3d& direction, double t_min,
                          double t_max) const {
    std::vector<int> seen(cells.size(), 0);
    accel::for_each_cell_along_ray(
        m.mesh.tree(), origin, direction, t_min, t_max, [](std::uint32_t) { return 255u; },
        [&](std::int64_t flat) {
          ++seen[std::size_t(flat)];
          return t_max;
        });
    return seen;
  }

  void check(const Vec3d& origin, const Vec3d& direction, double t_min, double t_max) const {
    const std::vector<int> seen = visits(origin, direction, t_min, t_max);
    for (std::size_t c = 0; c < cells.size(); ++c) {
      ASSERT_LE(seen[c], 1);
      if (meets_box(cells[c], origin, direction, t_min, t_max)) {
        ASSERT_EQ(seen[c], 1) << "cell " << c << ", origin " << origin.x << " " << origin.y << " "
                              << origin.z << ", direction " << direction.x << " " << direction.y
                              << " " << direction.z;
      }
    }
  }
};

test::TestMesh box(test::MeshKind kind, double offset, double scale) {
  return test::make_mesh(
      {.kind = kind, .size = 5, .offset = offset, .scale = {scale, scale, scale}}, 51);
}

} // namespace

TEST(Rays, MeetEveryCellOnTheirWay) {
  test::Random random(52);
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::tetrahedra})
    for (const double offset : {0.0, 1e7})
      for (const double scale : {1.0, 1e-3}) {
        const fixtures::Committed m(box(kind, offset, scale));
        const Walk walk(m);
        const Vec3d low = m.mesh.tree().bounds_min(), high = m.mesh.tree().bounds_max();
        const auto& x = m.arrays.points;
        for (int i = 0; i < 400; ++i) {
          const Vec3d inside = random.uniform(low, high);
          Vec3d direction = random.uniform({-1, -1, -1}, {1, 1, 1});
          Vec3d origin = inside; // a ray that starts in the mesh
          if (i % 4 == 1)
            origin = inside - 7 * scale * direction;
          // Parallel to one or two axes, exactly or nearly, level with vertices.
          const auto v = 3 * std::size_t(random.below(int(x.size() / 3)));
          if (i % 4 >= 2) {
            for (int a = 0; a < 3; ++a)
              if (random.below(2))
                origin[a] = x[v + std::size_t(a)];
            constexpr double nearly[] = {0.0, -0.0, 1e-17, -1e-300, 5e-324, -5e-324};
            direction[random.below(3)] = nearly[random.below(6)];
            if (i % 4 == 3)
              direction[random.below(3)] = nearly[random.below(6)];
          }
          if (direction == Vec3d{0, 0, 0})
            continue;
          walk.check(origin, direction, 0.0, i % 8 < 4 ? HUGE_VAL : 2 * scale);
          walk.check(origin, direction, scale, 20 * scale);
        }
      }
}

TEST(Rays, VisitTheSameCellsOnEverySimdTarget) {
  test::Random random(53);
  const fixtures::Committed m(box(test::MeshKind::tetrahedra, 1e7, 1.0));
  const Walk walk(m);
  const Vec3d low = m.mesh.tree().bounds_min(), high = m.mesh.tree().bounds_max();
  for (int i = 0; i < 100; ++i) {
    const Vec3d origin = random.uniform(low, high);
    Vec3d direction = random.uniform({-1, -1, -1}, {1, 1, 1});
    if (i % 3 == 0)
      direction[random.below(3)] = 0.0;
    const std::vector<int> seen = walk.visits(origin, direction, 0.0, 3.0);
    for (const std::int64_t target : fixtures::simd_targets()) {
      fixtures::use_simd_target(target);
      EXPECT_EQ(walk.visits(origin, direction, 0.0, 3.0), seen) << hwy::TargetName(target);
    }
    fixtures::use_simd_target(0);
  }
}

TEST(Rays, StopWhereTheyAreTold) {
  const fixtures::Committed m(box(test::MeshKind::hexahedra, 0, 1));
  // The first visit ends the ray: the rest of a chain of five cells is farther.
  int visits = 0;
  accel::for_each_cell_along_ray(
      m.mesh.tree(), {-1, 2.5, 2.5}, {1, 0, 0}, 0, 100, [](std::uint32_t) { return 255u; },
      [&](std::int64_t) {
        ++visits;
        return 0.0;
      });
  EXPECT_GE(visits, 1);
  EXPECT_LE(visits, accel::most_leaf_cells);
  // What is not accepted is not visited.
  accel::for_each_cell_along_ray(
      m.mesh.tree(), {-1, 2.5, 2.5}, {1, 0, 0}, 0, 100, [](std::uint32_t) { return 0u; },
      [](std::int64_t) {
        ADD_FAILURE();
        return 0.0;
      });
}
