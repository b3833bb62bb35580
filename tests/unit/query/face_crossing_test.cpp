// Where segments leave cells and the mesh, against slabs, a bilinear patch and holes.
#include "query/walk/face_crossing.h"
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::all_kinds;
using test::box;
using test::Random;

namespace {

double length(const Vec3d& v) {
  return std::hypot(v.x, v.y, v.z);
}

/// Where a + t (b - a) leaves a box that holds a; infinity if it does not. axis: of the face.
double slab_exit(const Vec3d& low, const Vec3d& high, const Vec3d& a, const Vec3d& b, int& axis) {
  double t = INFINITY;
  for (int k = 0; k < 3; ++k) {
    const double d = b[k] - a[k], to = d > 0 ? high[k] : low[k];
    if (d != 0 && (b[k] > high[k] || b[k] < low[k]) && (to - a[k]) / d < t) {
      t = (to - a[k]) / d;
      axis = k;
    }
  }
  return t;
}

} // namespace

TEST(LeaveMesh, BoxesAreLeftThroughTheirSides) {
  for (const auto kind : all_kinds)
    for (const double offset : {0.0, 6.4e6})
      for (const Vec3d scale : {Vec3d{1, 1, 1}, Vec3d{1e5, 1e5, 1}, Vec3d{1, 1e-3, 1}}) {
        const test::TestMesh mesh = box(kind, 4, 0.2, offset, scale);
        const fixtures::Committed m(mesh);
        const query::Sampler sampler = m.sampler();
        const Vec3d size = mesh.high - mesh.low;
        std::vector<Vec3d> starts = test::inner_points(m.mesh.mesh().view(), 60, 5);
        for (const Vec3d& v : mesh.vertices) // corners, edges and sides included
          starts.push_back(v);
        Random random(7);
        for (const Vec3d& a : starts) {
          const query::Location at = sampler.locate(a);
          ASSERT_TRUE(at);
          Vec3d b = a;
          const int how = random.below(3); // any way, along an axis, in a plane
          for (int k = 0; k < 3; ++k)
            if (how == 0 || (how == 1 && k == random.below(3)) || (how == 2 && k != 1))
              b[k] += random.uniform(-2, 2) * size[k];
          int axis = -1;
          const double t = slab_exit(mesh.low, mesh.high, a, b, axis);
          const auto exit = query::leave_mesh(sampler, at.cell, a, b);
          const std::string what = std::string(kind_name(kind)) + ", offset " +
                                   std::to_string(offset) + ", from " + test::text(a) + " to " +
                                   test::text(b);
          ASSERT_EQ(bool(exit), std::isfinite(t)) << what;
          if (!exit)
            continue;
          // Rounding of coordinates is what the place is known to; across a slanted side it counts
          // by the slant.
          const double rounding = 2e-15 * std::max({std::abs(offset), size.x, size.y, size.z});
          const double side = exit->normal[axis] > 0 ? mesh.high[axis] : mesh.low[axis];
          const double along = std::abs(b[axis] - a[axis]);
          EXPECT_NEAR(exit->t, t, 20 * rounding / along + 1e-14) << what;
          // A ray through an edge of the box may take either side.
          const Vec3d p = a + t * (b - a);
          int on = 0, normals = 0;
          for (int k = 0; k < 3; ++k) {
            on += std::min(std::abs(p[k] - mesh.low[k]), std::abs(p[k] - mesh.high[k])) <
                  1e-9 * size[k] + 4 * rounding;
            normals += std::abs(std::abs(exit->normal[k]) - 1) < 1e-12;
          }
          EXPECT_EQ(normals, 1) << what << ", normal " << test::text(exit->normal);
          if (on == 1) {
            EXPECT_GT(exit->normal[axis] * (b[axis] - a[axis]), 0) << what;
            EXPECT_NEAR(exit->point[axis], side, rounding) << what;
            EXPECT_EQ(exit->inside[axis], side) << what;
          }
          EXPECT_GE(exit->face, 0);
          EXPECT_TRUE(sampler.locate(exit->inside)) << what;
          EXPECT_EQ(sampler.locate(exit->inside).cell, exit->owner) << what;
          // Beside the segment the point may lie by rounding over the angle at which faces meet.
          EXPECT_LT(length(exit->inside - p),
                    1e-9 * length(b - a) + 40 * rounding * (1 + length(b - a) / along))
              << what;
        }
      }
}

TEST(LeaveMesh, NothingIsLeftInside) {
  for (const auto kind : all_kinds) {
    const fixtures::Committed m(box(kind, 4, 0.2, 0, {1e5, 1, 1}));
    const query::Sampler sampler = m.sampler();
    const auto points = test::hard_points(m.mesh.mesh().view(), 600, 11);
    int tried = 0;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const query::Location a = sampler.locate(points[i]), b = sampler.locate(points[i + 1]);
      // Points on the sides may be joined within a side, where rounding decides.
      const auto within = [&](const Vec3d& p) {
        return p.x > 1 && p.x < 399999 && p.y > 1e-5 && p.y < 3.99999 && p.z > 1e-5 &&
               p.z < 3.99999;
      };
      if (!a || !b || !within(points[i]) || !within(points[i + 1]))
        continue;
      ++tried;
      EXPECT_FALSE(query::leave_mesh(sampler, a.cell, points[i], points[i + 1]))
          << kind_name(kind) << " from " << test::text(points[i]) << " to "
          << test::text(points[i + 1]);
    }
    EXPECT_GT(tried, 50);
  }
}

TEST(LeaveMesh, HolesHaveWalls) {
  // A block of 6 x 6 x 6 without its middle 2 x 2 x 2.
  test::TestMesh mesh = box(test::MeshKind::voxels, 6);
  std::erase_if(mesh.cells, [&](const test::MeshCell& c) {
    const Vec3d p = mesh.vertices[std::size_t(c.vertices[0])];
    return p.x >= 2 && p.x < 4 && p.y >= 2 && p.y < 4 && p.z >= 2 && p.z < 4;
  });
  const fixtures::Committed m(mesh);
  const query::Sampler sampler = m.sampler();
  const auto leave = [&](const Vec3d& a, const Vec3d& b) {
    return query::leave_mesh(sampler, sampler.locate(a).cell, a, b);
  };
  auto exit = leave({0.5, 2.5, 3.25}, {5.5, 2.5, 3.25}); // though the end is inside again
  ASSERT_TRUE(exit);
  EXPECT_DOUBLE_EQ(exit->t, 0.3);
  EXPECT_EQ(exit->inside.x, 2.0);
  EXPECT_TRUE((exit->normal == Vec3d{1, 0, 0}));
  // Along a wall, which is closed, and through the edge where walls meet.
  EXPECT_FALSE(leave({2, 2.5, 0.5}, {2, 2.5, 5.5}));
  EXPECT_FALSE(leave({2, 2, 0.5}, {2, 2, 5.5}));
  exit = leave({1, 1, 3}, {3, 3, 3});
  ASSERT_TRUE(exit);
  EXPECT_DOUBLE_EQ(exit->t, 0.5);
  EXPECT_TRUE((exit->inside == Vec3d{2, 2, 3}));
  EXPECT_TRUE((exit->normal == Vec3d{1, 0, 0}) || (exit->normal == Vec3d{0, 1, 0}));
  // Through the corner of the hole, at which its cells merely touch.
  exit = leave({1, 1, 1}, {3, 3, 3});
  ASSERT_TRUE(exit);
  EXPECT_TRUE((exit->inside == Vec3d{2, 2, 2}));
  EXPECT_EQ(exit->normal.x + exit->normal.y + exit->normal.z, 1.0);
}

TEST(LeaveMesh, BilinearFacesAreMetWhereTheyAre) {
  // The top is z = 1 + h (2 x - 1)(2 y - 1), on a base that is flat.
  for (const double h : {0.0, 1e-9, 0.2, -0.4})
    for (const Vec3d scale : {Vec3d{1, 1, 1}, Vec3d{1e5, 1e5, 1}}) {
      test::TestMesh mesh;
      for (const double z : {0.0, 1.0})
        for (const auto& [x, y] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
          mesh.vertices.push_back(
              {scale.x * x, scale.y * y, z + z * h * (2 * x - 1) * (2 * y - 1)});
      mesh.cells.push_back({mesh::Shape::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7}});
      const fixtures::Committed m(mesh);
      Random random(3);
      for (int i = 0; i < 300; ++i) {
        const Vec3d a{scale.x * random.uniform(0.1, 0.9), scale.y * random.uniform(0.1, 0.9),
                      random.uniform(0.01, 0.5)};
        const Vec3d b{scale.x * random.uniform(0.1, 0.9), scale.y * random.uniform(0.1, 0.9),
                      random.uniform(1.5, 3)};
        const auto out = query::leave_mesh(m.sampler(), 0, a, b);
        ASSERT_TRUE(out) << test::text(a) << test::text(b);
        const double u = 2 * out->point.x / scale.x - 1, v = 2 * out->point.y / scale.y - 1;
        EXPECT_NEAR(out->point.z, 1 + h * u * v, 4e-15); // a few roundings of 1
        EXPECT_EQ(out->face, 5);
        const Vec3d p = a + out->t * (b - a);
        EXPECT_LT(length(p - out->point), 1e-14 * scale.x);
        Vec3d normal{-2 * h * v / scale.x, -2 * h * u / scale.y, 1};
        normal = normal / length(normal);
        EXPECT_LT(length(normal - out->normal), 1e-14);
        EXPECT_EQ(out->owner, 0);
        EXPECT_LT(length(out->inside - out->point), 1e-13 * scale.x);
      }
    }
}

TEST(LeaveMesh, DegenerateSegmentsAndCellsAnswer) {
  const test::TestMesh mesh = box(test::MeshKind::mixed, 3, 0.2);
  const fixtures::Committed m(mesh);
  const mesh::MeshView& view = m.mesh.mesh().view();
  const Vec3d p = test::inner_points(view, 1, 1)[0];
  const std::int64_t cell = m.sampler().locate(p).cell;
  EXPECT_FALSE(query::leave_mesh(m.sampler(), cell, p, p));
  EXPECT_FALSE(query::leave_mesh(m.sampler(), cell, p, {INFINITY, 0, 0}));
  EXPECT_FALSE(query::leave_mesh(m.sampler(), -1, p, {9, 9, 9}));
  for (const double far : {1e10, 1e100, 1e300}) {
    const auto exit = query::leave_mesh(m.sampler(), cell, p, {far, p.y, p.z});
    ASSERT_TRUE(exit) << far;
    EXPECT_EQ(exit->inside.x, 3.0);
    EXPECT_TRUE(std::isfinite(exit->t));
  }
  // A step too small to move off the point.
  EXPECT_FALSE(query::leave_mesh(m.sampler(), cell, p, p + Vec3d{1e-300, 0, 0}));
}
