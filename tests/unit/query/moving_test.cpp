// Between two steps: a point is located in the mesh that the two steps' vertices blend to.
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::box;
using test::same_bits;

namespace {

void check_blended(test::MeshKind kind, double offset, double distance) {
  const test::TestMesh from = box(kind, 5, 0.15, offset);
  fixtures::Committed m(from);
  m.mesh.mesh().keep_earlier({}, m.threads);
  test::Random random(31);
  for (double& x : m.arrays.points)
    x += distance * (1 + random.uniform(-0.1, 0.1));
  m.commit(INSITU_CHANGED_GEOMETRY);
  m.mesh.show_earlier(m.threads);
  const mesh::MeshView& view = m.mesh.mesh().view();
  ASSERT_NE(view.earlier_points, nullptr);
  for (const double alpha : {0.0, 1.0 / 3, 0.999, 1.0}) {
    // The same mesh, blended beforehand.
    test::TestMesh between = from;
    for (std::size_t v = 0; v < between.vertices.size(); ++v) {
      const Vec3d now = view.pieces[0].point(std::int64_t(v));
      between.vertices[v] = (1.0 - alpha) * view.earlier_points[v] + alpha * now;
    }
    const fixtures::Committed expected(between);
    std::vector<Vec3d> points = test::hard_points(expected.mesh.mesh().view(), 500, 32);
    for (const Vec3d& v : between.vertices)
      points.push_back(v);
    for (const auto accuracy : {INSITU_STANDARD, INSITU_EXACT}) {
      std::vector<query::Location> batch(points.size());
      m.sampler().locate(m.threads, points, batch, {accuracy, alpha});
      for (std::size_t i = 0; i < points.size(); ++i) {
        const query::Location want = expected.sampler().locate(points[i], -1, {accuracy, 1.0});
        ASSERT_TRUE(same_bits(batch[i], want))
            << kind_name(kind) << ", offset " << offset << ", distance " << distance << ", alpha "
            << alpha << ", point " << i << " " << test::text(points[i]) << ": cells "
            << batch[i].cell << " " << want.cell;
        for (const std::int64_t hint : {std::int64_t(-1), want.cell})
          ASSERT_TRUE(same_bits(m.sampler().locate(points[i], hint, {accuracy, alpha}), want));
      }
    }
  }
}

} // namespace

TEST(Moving, PointsAreLocatedInTheBlendedMesh) {
  for (const auto kind :
       {test::MeshKind::hexahedra, test::MeshKind::wedges, test::MeshKind::pyramids,
        test::MeshKind::tetrahedra, test::MeshKind::mixed})
    for (const double distance : {1e-3, 0.7, 4.0})
      check_blended(kind, 0, distance);
}

// The blend rounds at the size of the coordinates, not at that of the displacement.
TEST(Moving, FarFromZero) {
  for (const double offset : {1e7, -1e10})
    for (const double distance : {1e-5, 1e-2, 1.0})
      check_blended(test::MeshKind::hexahedra, offset, distance);
}
