#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "unit/render/render_mesh.h"

/// Light on surfaces, by closed forms.
namespace insitu::test {
namespace {

using render::Color;
using render::FrameSettings;
using render::FrameStatistics;
using render::Light;
using Kind = render::Light::Kind;

constexpr double ambient = 0.3, diffuse = 0.7; // the defaults

Vec3d unit(const Vec3d& v) {
  return v / std::sqrt(dot(v, v));
}

/// One pixel that sees the middle of the box's x-y plane from above.
FrameSettings from_above() {
  FrameSettings s;
  s.width = s.height = 1;
  s.camera.position = {0.45, 0.55, 3};
  s.camera.look_at = {0.45, 0.55, 0};
  s.camera.up = {0, 1, 0};
  s.background = {0, 0, 0};
  return s;
}

class Lights : public testing::Test {
protected:
  Lights() { settings.isosurfaces.push_back({z, {0.25}, 1, Color{0.5f, 1.0f, 0.25f}}); }

  /// The factor on the plane's colour at (0.45, 0.55, 0.25).
  Vec3d factor(const std::vector<Light>& lights) {
    settings.lighting.lights = lights;
    const core::Image image = mesh.draw(settings, 1, &statistics);
    const float* p = image.pixel(0, 0);
    return {p[0] / 0.5, p[1] / 1.0, p[2] / 0.25};
  }
  void expect(const Vec3d& found, const Vec3d& expected) {
    for (int a = 0; a < 3; ++a) // float's rounding, a few times
      EXPECT_NEAR(found[a], expected[a], 1e-6 * (1 + expected[a]));
  }

  RenderMesh mesh{3, Shape::wedge, 0.2};
  render::ScalarField z = mesh.field("z", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
  FrameSettings settings = from_above();
  FrameStatistics statistics;
};

TEST_F(Lights, AddUpByTheirCosines) {
  expect(factor({}), {1, 1, 1}); // a headlight, seen head-on
  expect(factor({{Kind::head, {}, {0.5f, 1, 2}}}),
         {ambient + diffuse * 0.5, ambient + diffuse, ambient + diffuse * 2});
  const Vec3d slanted{3, 0, 4};
  expect(factor({{Kind::directional, slanted, {1, 0.5f, 0}}}),
         {ambient + diffuse * 0.8, ambient + diffuse * 0.4, ambient});
  expect(factor({{Kind::directional, -slanted}}), {ambient, ambient, ambient}); // behind
  // At distance 2 along the slanted direction.
  const Vec3d place = Vec3d{0.45, 0.55, 0.25} + 0.4 * slanted;
  const double lit = ambient + diffuse * 0.8 / 4;
  expect(factor({{Kind::point, place}}), {lit, lit, lit});
  expect(factor({{Kind::dome, {}, {0, 0, 1}}}), {ambient, ambient, 1});
  expect(factor({{Kind::dome, {}, {0, 0, 1}},
                 {Kind::point, place, {1, 0, 0}},
                 {Kind::directional, slanted, {1, 0, 0}}}),
         {lit + diffuse * 0.8, ambient, 1});
  // Seen from below, the other side is lit just so.
  settings.camera.position.z = -3;
  expect(factor({{Kind::directional, {3, 0, -4}}}),
         {ambient + diffuse * 0.8, ambient + diffuse * 0.8, ambient + diffuse * 0.8});
  EXPECT_EQ(statistics.shadow_rays, 0);
  EXPECT_EQ(statistics.occlusion_rays, 0);
}

TEST_F(Lights, ShadowsAreOfWhatLiesBetween) {
  settings.lighting.shadows = true;
  const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  z = mesh.field("z", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
  settings.isosurfaces[0].field = z;
  const Vec3d low{0.2, 0, 0.1}, high{0.1, 0, 0.6};
  const auto lit = [&](const Vec3d& l) { return ambient + diffuse * unit(l).z; };
  // A wall at x = 0.55: towards +x the low light meets it below the box's top, at 0.25 + 0.1 / 2.
  expect(factor({{Kind::directional, low}}), {lit(low), lit(low), lit(low)});
  EXPECT_EQ(statistics.shadow_rays, 1);
  settings.isosurfaces.push_back({x, {0.55}, 1});
  expect(factor({{Kind::directional, low}}), {ambient, ambient, ambient});
  // The light from higher meets it at z = 0.85, from higher still not at all.
  expect(factor({{Kind::directional, high}}), {ambient, ambient, ambient});
  const Vec3d higher{0.1, 0, 0.9};
  expect(factor({{Kind::directional, higher}}), {lit(higher), lit(higher), lit(higher)});
  // Nor is a point light this side of the wall in its shadow, but one beyond is.
  const double near = ambient + diffuse / std::sqrt(2.0) / 0.0128;
  expect(factor({{Kind::point, {0.53, 0.55, 0.33}}}), {near, near, near});
  expect(factor({{Kind::point, {0.65, 0.55, 0.45}}}), {ambient, ambient, ambient});
  // Half transparent, it takes half; clipped, nothing.
  settings.isosurfaces[1].opacity = 0.5;
  const double half = ambient + 0.5 * diffuse * unit(low).z;
  expect(factor({{Kind::directional, low}}), {half, half, half});
  settings.clips.push_back({render::Clip::Kind::plane, {0.54, 0, 0}, {1, 0, 0}});
  expect(factor({{Kind::directional, low}}), {lit(low), lit(low), lit(low)});
  // Behind the surface: no ray is needed.
  expect(factor({{Kind::directional, {0, 0, -1}}}), {ambient, ambient, ambient});
  EXPECT_EQ(statistics.shadow_rays, 0);
}

TEST_F(Lights, ASphereShadesADiscOnAPlane) {
  RenderMesh ball(16, Shape::hexahedron, 0.2);
  const Vec3d centre{0.5, 0.5, 0.6};
  const double radius = 0.2;
  auto r2 =
      ball.field("r2", INSITU_VERTEX, [&](const Vec3d& p) { return dot(p - centre, p - centre); });
  auto floor = ball.field("z", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
  FrameSettings s = box_frame(64);
  s.camera.position = {0.5, -2.5, 0.35};
  s.camera.look_at = {0.5, 0.5, 0.15};
  s.camera.up = {0, 0, 1};
  s.camera.fov = 25;
  s.lighting.lights = {{Kind::directional, {0, 0, 2}}};
  s.lighting.shadows = true;
  s.isosurfaces.push_back({floor, {0.1}, 1, Color{1, 1, 1}});
  s.isosurfaces.push_back({r2, {radius * radius}, 1, Color{0, 0, 1}});
  const core::Image image = ball.draw(s);
  const render::RayGenerator rays(s.camera, 64, 64);
  int dark = 0, bright = 0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const float* p = image.pixel(x, y);
      if (p[0] == 0)
        continue; // not the floor
      const render::Ray ray = rays(x, y);
      const Vec3d at = ray.origin + ((0.1 - ray.origin.z) / ray.direction.z) * ray.direction;
      const double r = std::hypot(at.x - 0.5, at.y - 0.5);
      // The drawn sphere is at most h^2 / 4 smaller in r^2 than the true one; see sphere_test.
      if (r < 0.185) {
        ++dark;
        EXPECT_NEAR(p[0], ambient, 1e-6) << x << ", " << y;
      } else if (r > radius * (1 + 1e-9)) {
        ++bright;
        EXPECT_NEAR(p[0], ambient + diffuse, 1e-6) << x << ", " << y;
      }
    }
  EXPECT_GT(dark, 12);
  EXPECT_GT(bright, 150);
}

/// A convex surface does not shade itself, at any scale and offset.
TEST(Shade, NoAcne) {
  for (const auto& [scale, offset] : {std::pair{1.0, 0.0}, {1e-6, 0.0}, {1e3, 6.4e6}, {1e9, 1e9}}) {
    TestMesh cells = box_cells(12, Shape::hexahedron, 0.2);
    for (Vec3d& v : cells.vertices)
      v = scale * v + Vec3d{offset, offset, offset};
    RenderMesh mesh(cells);
    const Vec3d centre = scale * Vec3d{0.5, 0.5, 0.5} + Vec3d{offset, offset, offset};
    const auto r2 = mesh.field("r2", INSITU_VERTEX, [&](const Vec3d& p) {
      return dot(p - centre, p - centre) / (scale * scale);
    });
    FrameSettings s = box_frame(96);
    s.camera.look_at = centre;
    s.camera.position = centre + scale * Vec3d{1.1, 0.8, 1.7};
    const Vec3d l = unit({1, 2, 1.5});
    s.lighting.lights = {{Kind::directional, l}};
    s.isosurfaces.push_back({r2, {0.16}, 1, Color{1, 1, 1}});
    s.depth = true;
    const auto plain =
        render::render_frame(mesh.sampler(), s, mesh.committed.threads, mesh.committed.memory);
    s.lighting.shadows = true;
    FrameStatistics statistics;
    const core::Image shaded = mesh.draw(s, 0, &statistics);
    const render::RayGenerator rays(s.camera, 96, 96);
    int lit = 0;
    for (int y = 0; y < 96; ++y)
      for (int x = 0; x < 96; ++x) {
        const render::Ray ray = rays(x, y);
        const double t = plain.depth[std::size_t(y * 96 + x)];
        if (!std::isfinite(t))
          continue;
        const Vec3d normal = unit(ray.origin + t * ray.direction - centre);
        if (dot(normal, l) < 0.2) // facets' own horizon lies a cell's angle lower
          continue;
        ++lit;
        EXPECT_EQ(shaded.pixel(x, y)[0], plain.color.pixel(x, y)[0])
            << scale << " " << offset << ": " << x << ", " << y;
      }
    EXPECT_GT(lit, 1500);
    EXPECT_GT(statistics.shadow_rays, lit);
  }
}

TEST(Shade, OcclusionBesideAWall) {
  RenderMesh mesh(4, Shape::hexahedron, 0.2);
  const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  const auto z = mesh.field("z", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
  FrameSettings s = from_above();
  s.width = s.height = 48;
  s.camera.position = {0.52, 0.5, 3};
  s.camera.look_at = {0.52, 0.5, 0};
  s.camera.orthographic_height = 0.3;
  s.lighting.ambient = 1;
  s.lighting.diffuse = 0;
  s.lighting.occlusion_samples = 64;
  s.lighting.occlusion_distance = 0.25;
  s.isosurfaces.push_back({z, {0.3}, 1, Color{1, 1, 1}});
  FrameStatistics statistics;
  const core::Image open = mesh.draw(s, 0, &statistics);
  EXPECT_EQ(statistics.occlusion_rays, 48 * 48 * 64);
  EXPECT_EQ(statistics.shadow_rays, 0);
  for (int i = 0; i < 48; ++i)
    EXPECT_EQ(open.pixel(i, i)[0], 1.0f); // a plane hides nothing of its own sky
  s.isosurfaces.push_back({x, {0.4}, 1, Color{0, 1, 0}});
  const core::Image image = mesh.draw(s);
  const render::RayGenerator rays(s.camera, 48, 48);
  int columns = 0;
  for (int i = 0; i < 48; ++i) {
    const double d = rays(i, 0).origin.x - 0.4;
    if (d < 1e-3)
      continue;
    // Rays go evenly through the unit disc (Malley); those beyond the chord at d / distance end at
    // the wall.
    const double c = std::fmin(1.0, d / 0.25);
    const double expected = 1 - (std::acos(c) - c * std::sqrt(1 - c * c)) / M_PI;
    double sum = 0;
    for (int y = 0; y < 48; ++y)
      sum += image.pixel(i, y)[0] / 48;
    // 48 x 64 samples; independent ones would have a deviation of 0.009 at most.
    EXPECT_NEAR(sum, expected, 0.02) << "distance " << d;
    ++columns;
  }
  EXPECT_GT(columns, 30);
}

TEST(Shade, SameBytesForAnyNumberOfThreads) {
  RenderMesh mesh(6, Shape::tetrahedron, 0.2);
  const auto r2 = mesh.field("r2", INSITU_VERTEX, [](const Vec3d& p) {
    return dot(p - Vec3d{0.5, 0.5, 0.5}, p - Vec3d{0.5, 0.5, 0.5});
  });
  FrameSettings s = box_frame(40);
  s.isosurfaces.push_back({r2, {0.05, 0.2}, 0.6});
  s.lighting.shadows = true;
  s.lighting.occlusion_samples = 4;
  s.lighting.lights = {{Kind::dome}, {Kind::directional, {1, 1, 1}}};
  const core::Image one = mesh.draw(s, 1), four = mesh.draw(s, 4);
  EXPECT_EQ(std::memcmp(one.rgba.data(), four.rgba.data(), one.rgba.size() * sizeof(float)), 0);
}

} // namespace
} // namespace insitu::test
