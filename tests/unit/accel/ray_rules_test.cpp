// The rules of the ray methods as plain code, against exact containment.
#include <gtest/gtest.h>

#include "accel/faces/mesh_faces.h"
#include "accel/rays/ray_rules.h"
#include "cells/exact/contain_exact.h"
#include "fixtures/committed.h"

using namespace insitu;
using accel::FaceTriangle;
using math::Vec3d;

namespace {

/// Two hexahedra whose common face is bent.
test::TestMesh two_cells(std::uint64_t seed) {
  test::Random random(seed);
  test::TestMesh mesh;
  for (int k = 0; k < 3; ++k)
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
      mesh.vertices.push_back(Vec3d{double(x), double(y), double(k)} +
                              (k == 1 ? 0.3 : 0.0) * random.uniform({-1, -1, -1}, {1, 1, 1}));
  mesh.cells = {{mesh::Shape::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7}},
                {mesh::Shape::hexahedron, {4, 5, 6, 7, 8, 9, 10, 11}}};
  return mesh;
}

} // namespace

TEST(RayRules, TheSideOfThePatchTellsTheCell) {
  int checked = 0;
  for (std::uint64_t seed = 1; seed < 40; ++seed) {
    const fixtures::Committed m(two_cells(seed), 1);
    const mesh::MeshView& view = m.mesh.mesh().view();
    core::Memory memory;
    accel::MeshFaces table(memory);
    table.build(view, m.threads);
    core::Buffer<FaceTriangle> triangles(memory, INSITU_MEMORY_BUILD);
    table.triangles(view, m.threads, accel::Method::shared_bilinear_faces, triangles);
    mesh::CellVertices cells[2];
    for (int c = 0; c < 2; ++c)
      mesh::gather(view, c, cells[c]);
    test::Random random(seed);
    for (const FaceTriangle& t : triangles) {
      if (t.corner == accel::none || t.front == accel::none || t.back == accel::none)
        continue;
      const std::uint32_t ids[4] = {t.vertices[0], t.vertices[1], t.vertices[2], t.corner};
      Vec3d quad[4];
      for (int k = 0; k < 4; ++k)
        quad[k] = view.pieces[0].point(ids[k]);
      for (int i = 0; i < 100; ++i) {
        double w[4], sum = 0;
        for (double& x : w)
          sum += x = random.uniform(0.001, 1);
        Vec3d p{};
        for (int k = 0; k < 4; ++k)
          p += (w[k] / sum) * quad[k];
        const auto holds = [&](std::uint32_t c) {
          return cells::contain_exact(cells[c].shape, cells[c].x, p).where ==
                 cells::Containment::inside;
        };
        if (holds(0) == holds(1)) // out at the sides
          continue;
        const auto beside = [&](const FaceTriangle&) { return accel::is_beside(quad, p); };
        const std::uint32_t told = accel::cell_of_hit(t, true, beside);
        ASSERT_EQ(told, holds(0) ? 0u : 1u) << "seed " << seed;
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 5000);
}

TEST(RayRules, AHitFromBehindDoesNotMakeAFlatQuadCurved) {
  // Corners flat to rounding: from a point far behind, a c - b d is noise of either sign.
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d u = random.uniform({0.5, -1, -1}, {1, 1, 1}),
                v = random.uniform({-1, 0.5, -1}, {1, 1, 1});
    const Vec3d at = random.uniform({1, 1, 1}, {2, 2, 2}), n = cross(u, v);
    const Vec3d quad[4] = {at, at + u, at + u + v, at + v};
    const Vec3d p = at + 0.5 * u + 0.3 * v + random.uniform(0.1, 1) * n;
    EXPECT_FALSE(accel::is_beside(quad, p));
  }
}

TEST(RayRules, FrontAndBackOfAPlainTriangle) {
  const FaceTriangle t{{0, 1, 2}, accel::none, 5, 6};
  const auto beside = [](const FaceTriangle&) -> bool {
    ADD_FAILURE() << "asked for nothing";
    return true;
  };
  EXPECT_EQ(accel::cell_of_hit(t, false, beside), 5u);
  EXPECT_EQ(accel::cell_of_hit(t, true, beside), 6u);
}

TEST(RayRules, DirectionsVaryAndHaveLengthOne) {
  test::Random random(4);
  Vec3d sum{};
  constexpr int many = 20000;
  for (int i = 0; i < many; ++i) {
    const math::Vec3f d = accel::ray_direction(random.uniform({-1, -1, -1}, {1, 1, 1}));
    ASSERT_NEAR(dot(d, d), 1.0f, 1e-5f);
    sum += Vec3d{d.x, d.y, d.z} / double(many);
  }
  for (int a = 0; a < 3; ++a)
    EXPECT_NEAR(sum[a], 0, 0.03);
}

TEST(RayRules, RaysStartAtThePointInTheFrame) {
  test::Random random(5);
  const Vec3d origin{6.4e6, -6.4e6, 1e3};
  for (int i = 0; i < 1000; ++i) {
    const Vec3d d = random.uniform({-1, -1, -1}, {1, 1, 1}), p = origin + d;
    const accel::PointRay ray = accel::point_ray(p, origin, 1.5f);
    EXPECT_EQ(ray.length, 1.5f);
    const math::Vec3f direction = accel::ray_direction(p);
    for (int a = 0; a < 3; ++a) {
      // The difference is exact in double, then rounded once: no digits go to the offset.
      EXPECT_EQ(ray.origin[a], float(p[a] - origin[a]));
      EXPECT_NEAR(ray.origin[a], d[a], 0x1p-24 + 0x1p-30); // 2^-30: of p at 6.4e6
      EXPECT_EQ(ray.direction[a], direction[a]);
    }
  }
  // The direction is the point's alone: in another frame it is the same.
  const Vec3d p{0.25, 0.5, 0.75};
  const math::Vec3f here = accel::point_ray(p, {}, 1).direction,
                    there = accel::point_ray(p, {1, 2, 3}, 2).direction;
  for (int a = 0; a < 3; ++a)
    EXPECT_EQ(here[a], there[a]);
}
