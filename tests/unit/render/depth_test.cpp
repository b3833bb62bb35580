#include <cmath>
#include <gtest/gtest.h>

#include "unit/render/render_mesh.h"

/// Depth and cell images.
namespace insitu::test {
namespace {

using render::FrameImages;
using render::FrameSettings;

FrameImages draw(RenderMesh& mesh, const FrameSettings& s) {
  return render::render_frame(mesh.sampler(), s, mesh.committed.threads, mesh.committed.memory);
}

TEST(Depth, OfAPlaneFromBothCameras) {
  RenderMesh mesh(4, Shape::hexahedron, 0.25);
  const auto plane = [](const Vec3d& p) { return p.x + 2 * p.y + 3 * p.z; };
  FrameSettings s = box_frame(48);
  s.isosurfaces.push_back({mesh.field("plane", INSITU_VERTEX, plane), {3.1}, 1});
  s.depth = s.cell = true;
  for (const double height : {0.0, 1.2}) {
    s.camera.orthographic_height = height;
    const FrameImages images = draw(mesh, s);
    ASSERT_EQ(images.depth.size(), 48u * 48u);
    ASSERT_EQ(images.cell.size(), 48u * 48u);
    const render::RayGenerator rays(s.camera, 48, 48);
    int hits = 0;
    for (int i = 0; i < 48 * 48; ++i) {
      const render::Ray ray = rays(i % 48, i / 48);
      const double t = (3.1 - plane(ray.origin)) / plane(ray.direction);
      const auto [near, far] = box_stretch(ray);
      if (std::fabs(t - near) < 1e-9 || std::fabs(t - far) < 1e-9)
        continue; // on the rim it may go either way
      const float found = images.depth[std::size_t(i)];
      const std::int64_t cell = images.cell[std::size_t(i)];
      if (!(t > near && t < far)) {
        EXPECT_EQ(found, HUGE_VALF);
        EXPECT_EQ(cell, -1);
        continue;
      }
      ++hits;
      EXPECT_NEAR(found, t, 1e-6); // rounded to float
      // The cell holds the place, as near as the surface is found.
      const query::Location at = mesh.sampler().locate(ray.origin + t * ray.direction, cell);
      EXPECT_EQ(at.cell, cell) << "pixel " << i;
    }
    EXPECT_GT(hits, 300);
  }
}

TEST(Depth, OfASphereBetweenTwoSpheres) {
  RenderMesh mesh(16, Shape::hexahedron, 0.2);
  const Vec3d centre{0.5, 0.5, 0.5};
  FrameSettings s = box_frame(48);
  s.isosurfaces.push_back(
      {mesh.field("r2", INSITU_VERTEX, [&](const Vec3d& p) { return dot(p - centre, p - centre); }),
       {0.16},
       1});
  s.depth = true;
  const FrameImages images = draw(mesh, s);
  EXPECT_TRUE(images.cell.empty()); // not asked for
  const render::RayGenerator rays(s.camera, 48, 48);
  // See sphere_test: the drawn surface lies between the spheres of r^2 and r^2 - h^2 / 4, h the
  // largest diagonal of a cell, at most that of a cube of 1.4 / 16.
  const double inner2 = 0.16 - 3 * 1.4 * 1.4 / 256 / 4;
  int hits = 0;
  for (int i = 0; i < 48 * 48; ++i) {
    const render::Ray ray = rays(i % 48, i / 48);
    const double along = dot(centre - ray.origin, ray.direction);
    const Vec3d miss = ray.origin + along * ray.direction - centre;
    const double closest2 = dot(miss, miss);
    const float found = images.depth[std::size_t(i)];
    if (closest2 > 0.16 * (1 + 1e-9)) {
      EXPECT_EQ(found, HUGE_VALF);
    }
    if (closest2 < inner2) {
      ++hits;
      EXPECT_GE(found, along - std::sqrt(0.16 - closest2) - 1e-6);
      EXPECT_LE(found, along - std::sqrt(inner2 - closest2) + 1e-6);
    }
  }
  EXPECT_GT(hits, 300);
}

TEST(Depth, IsWhereOpacityReachesAHalf) {
  RenderMesh mesh(4, Shape::hexahedron, 0.2);
  const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  FrameSettings s;
  s.width = s.height = 1;
  s.camera.position = {-1, 0.45, 0.55};
  s.camera.look_at = {0, 0.45, 0.55};
  s.camera.up = {0, 0, 1};
  s.depth = s.cell = true;
  const auto depth = [&] { return double(draw(mesh, s).depth[0]); };
  // Two surfaces of 0.4 let 0.36 through, so the second one is it.
  s.isosurfaces.push_back({x, {0.2, 0.6, 0.8}, 0.4});
  EXPECT_NEAR(depth(), 1.6, 1e-6);
  s.isosurfaces[0].opacity = 0.5;
  EXPECT_NEAR(depth(), 1.2, 1e-6);
  s.isosurfaces[0].opacity = 0.1;
  EXPECT_EQ(depth(), HUGE_VAL);
  // A homogeneous medium lets exp(-k x) through; samples begin at the box's face.
  s.isosurfaces.clear();
  s.volume = render::VolumeSettings{x, constant_function(0.75, 1.0)};
  s.volume->unit_distance = 1;
  s.volume->step = 0.25;
  const double k = -std::log(0.25);
  EXPECT_NEAR(depth(), 1 + std::log(2.0) / k, 1e-6);
  // A surface of 0.3 in it: the rest of a half comes after 0.5 / 0.7 of transmittance.
  s.isosurfaces.push_back({x, {0.1}, 0.3});
  EXPECT_NEAR(depth(), 1 + std::log(2.0 * 0.7) / k, 1e-6);
  // Or the surface itself is where it happens.
  s.isosurfaces[0] = {x, {0.4}, 0.3};
  EXPECT_NEAR(depth(), 1.4, 1e-6);
  s.background_alpha = 1; // the background is no depth
  s.volume.reset();
  EXPECT_EQ(depth(), HUGE_VAL);
}

} // namespace
} // namespace insitu::test
