// Points on the seams of processes have one owner.
#include <algorithm>
#include <cstdlib>
#include <gtest/gtest.h>

#include "../parallel/threaded_world.h"
#include "box_mesh.h"
#include "halo_parts.h"
#include "lane_runs.h"

namespace insitu::test {
namespace {

/// Of each cell its octant.
std::vector<int> octants(const TestMesh& mesh) {
  std::vector<int> process;
  for (const MeshCell& cell : mesh.cells) {
    const Vec3d x = mesh.vertices[std::size_t(cell.vertices[0])];
    process.push_back((x.x > -0.1) + 2 * (x.y > 0.1) + 4 * (x.z > 0.0));
  }
  return process;
}

/// A random point on a face, an edge or a vertex of one of the mesh's cells: of boxes exactly
/// there.
Vec3d point_on_a_feature(const TestMesh& mesh, bool of_boxes, Random& random) {
  const MeshCell& cell = mesh.cells[std::size_t(random.below(int(mesh.cells.size())))];
  const int n = mesh::vertex_count(cell.shape);
  const auto vertex = [&] {
    return mesh.vertices[std::size_t(cell.vertices[std::size_t(random.below(n))])];
  };
  const Vec3d a = vertex(), b = vertex();
  const double s = random.uniform(0.0, 1.0);
  if (!of_boxes)
    return s * a + (1.0 - s) * b; // of one vertex, of two, or of a diagonal
  Vec3d x;
  for (int axis = 0; axis < 3; ++axis) // a coordinate of a vertex, or one between those of two
    x[axis] = random.below(3) ? a[axis]
                              : std::clamp(s * a[axis] + (1.0 - s) * b[axis],
                                           std::min(a[axis], b[axis]), std::max(a[axis], b[axis]));
  return x;
}

/// INSITU_TEST_POINTS: so many, half of them on boxes.
TEST(Across, PointsOnSeamsAreOwnedOnce) {
  const char* const asked = std::getenv("INSITU_TEST_POINTS");
  const std::int64_t most = asked ? std::atoll(asked) : 20000;
  for (const MeshKind kind : {MeshKind::voxels, MeshKind::hexahedra}) {
    const TestMesh mesh = mesh_of(kind, 8);
    const HaloPlan whole(mesh, std::vector<int>(mesh.cells.size()), 1, 0),
        plan(mesh, octants(mesh), 8, 1);
    run_processes(8, [&](parallel::World& world) {
      HaloPart alone(whole, 0), part(plan, world.rank());
      alone.m.commit();
      part.m.commit();
      Random random(77);
      for (std::int64_t left = most / 2; left > 0;) {
        std::vector<Vec3d> points(std::size_t(std::min<std::int64_t>(left, 100'000)));
        left -= std::int64_t(points.size());
        std::vector<std::int64_t> owners;
        for (Vec3d& x : points) {
          x = point_on_a_feature(mesh, kind == MeshKind::voxels, random);
          const query::Location at = part.m.mesh.sampler().locate(x, -1, {});
          owners.push_back(at && part.is_own(at.cell) ? 1 + part.global(at.cell) : 0);
        }
        std::vector<std::int64_t> sums = owners;
        world.reduce(std::span(sums), parallel::Reduction::sum);
        std::size_t wrong = 0;
        for (std::size_t i = std::size_t(world.rank()); i < points.size(); i += 8) {
          const query::Location at = alone.m.mesh.sampler().locate(points[i], -1, {});
          wrong += sums[i] != (at ? 1 + at.cell : 0);
        }
        EXPECT_EQ(wrong, 0U);
      }
    });
  }
}

} // namespace
} // namespace insitu::test
