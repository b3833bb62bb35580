#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "unit/render/path_mesh.h"

/// Shadows of a volume on surfaces and of surfaces in a volume, by closed forms.
namespace insitu::test {
namespace {

using render::Color;
using render::FrameSettings;
using render::FrameStatistics;
using render::Light;
using Kind = render::Light::Kind;

constexpr double ambient = 0.3, diffuse = 0.7; // the defaults

double one(const Vec3d&) {
  return 1;
}

/// A square of side 2 r across the x axis, opaque.
render::BodySettings plate(const Vec3d& middle, double r, const Color& color = {1, 1, 1}) {
  render::TriangleList list;
  list.source = "plate";
  const Vec3d y{0, r, 0}, z{0, 0, r};
  for (const Vec3d& corner : {middle - y - z, middle + y - z, middle + y + z, middle - y - z,
                              middle + y + z, middle - y + z})
    list.corners.push_back(corner);
  return {std::make_shared<render::TriangleList>(list), 1, color};
}

bool same(const core::Image& a, const core::Image& b) {
  return std::memcmp(a.rgba.data(), b.rgba.data(), a.rgba.size() * sizeof(float)) == 0;
}

/// The plane z = 1/4 in a black absorbing medium, seen from above.
TEST(VolumeShadow, DimsTheLightOnASurfaceByBeersLaw) {
  RenderMesh mesh(6, Shape::hexahedron, 0.2);
  const auto z = mesh.field("z", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
  const auto f = mesh.field("f", INSITU_VERTEX, one);
  const double extinction = 1.3;
  for (const double density : {0.0, 2.0}) { // marched, and path traced
    FrameSettings s;
    s.width = s.height = density > 0 ? 12 : 1;
    s.camera.position = {0.45, 0.55, 3};
    s.camera.look_at = {0.45, 0.55, 0};
    s.camera.up = {0, 1, 0};
    s.camera.orthographic_height = 1e-9;
    s.background = {0, 0, 0};
    s.isosurfaces.push_back({z, {0.25}, 1, Color{1, 1, 1}});
    s.lighting.shadows = s.lighting.volume_shadows = true;
    s.volume = render::VolumeSettings{f, constant_function(opacity_of(extinction), 0.0)};
    s.volume->step = 0.005;
    s.volume->unit_distance = 1;
    const double sigma = density > 0 ? density * extinction : extinction;
    if (density > 0) {
      s.path_tracing.emplace();
      s.path_tracing->density = density;
      s.path_tracing->samples = 400;
      s.path_tracing->scattering = render::Scattering::none;
    }
    const double seen = std::exp(-0.75 * sigma);
    const Vec3d above{0, 0, 2}, slanted{5, 0, 12};
    for (const auto& [light, cosine, length] :
         {std::tuple{Light{Kind::directional, above}, 1.0, 0.75},
          {Light{Kind::directional, slanted}, 12.0 / 13, 0.8125},
          {Light{Kind::point, {0.45, 0.55, 0.5}, {0.25f * 0.25f, 0.0625f, 0.0625f}}, 1.0, 0.25}}) {
      s.lighting.lights = {light};
      FrameStatistics statistics;
      const core::Image image = mesh.draw(s, 1, &statistics);
      double mean = 0;
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
          mean += double(image.pixel(x, y)[0]) / (image.width * image.height);
      const double lit = seen * (ambient + diffuse * cosine * std::exp(-length * sigma));
      // Half a step is left out at most: 0.0025 * 2.6 of the light. Path traced, the way to the
      // surface is noise: 57600 paths.
      EXPECT_NEAR(mean, lit, (density > 0 ? 0.02 : 0.007) * lit) << density << " " << length;
      EXPECT_GT(statistics.shadow_samples, 0);
    }
  }
}

/// What does not ask for them has none of them.
TEST(VolumeShadow, CostsNothingWhereItIsNotAskedFor) {
  RenderMesh mesh(6);
  const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  FrameSettings s = box_frame(24);
  s.isosurfaces.push_back({x, {0.3}, 0.7, Color{1, 1, 1}});
  s.lighting.shadows = true;
  s.lighting.lights = {{Kind::directional, {1, 1, 1}}};
  FrameStatistics alone, with_volume;
  mesh.draw(s, 1, &alone);
  s.volume = render::VolumeSettings{x, constant_function(0.1)};
  s.volume->shading = true;
  mesh.draw(s, 1, &with_volume);
  EXPECT_EQ(with_volume.shadow_rays, alone.shadow_rays);
  EXPECT_EQ(with_volume.shadow_samples, 0);
  // Nor with them, where no surface is there to cast or to get one.
  s.isosurfaces.clear();
  const core::Image plain = mesh.draw(s);
  s.lighting.volume_shadows = true;
  EXPECT_TRUE(same(plain, mesh.draw(s, 1, &with_volume)));
  EXPECT_EQ(with_volume.shadow_samples, 0);
}

/// An empty part of the volume casts none, and is not sampled.
TEST(VolumeShadow, SkipsWhatIsEmpty) {
  RenderMesh mesh(16);
  const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  FrameSettings s = box_frame(48);
  s.isosurfaces.push_back({x, {0.2}, 1, Color{1, 1, 1}});
  s.lighting.shadows = s.lighting.volume_shadows = true;
  s.lighting.lights = {{Kind::directional, {1, 0.2, 0.1}}};
  s.volume =
      render::VolumeSettings{x, {render::ColorMap::built_in("grey"), 0, 1, {{0.8, 0}, {0.8, 0.5}}}};
  FrameStatistics skipping, all;
  const core::Image image = mesh.draw(s, 1, &skipping);
  s.volume->skip_empty = false;
  EXPECT_TRUE(same(image, mesh.draw(s, 1, &all)));
  EXPECT_GT(skipping.shadow_samples, 0);
  EXPECT_LT(double(skipping.shadow_samples), 0.7 * double(all.shadow_samples));
}

/// A lit volume behind a plate: within its shadow only the ambient light is left.
TEST(VolumeShadow, SurfacesShadeALitVolume) {
  RenderMesh mesh(6, Shape::hexahedron, 0.2);
  const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  FrameSettings s = one_ray(1);
  s.path_tracing.reset();
  s.lighting.enabled = true;
  s.volume = render::VolumeSettings{x, constant_function(opacity_of(2.0))};
  s.volume->unit_distance = 1;
  s.volume->step = 0.01;
  s.volume->shading = true;
  // Light from where the viewer is, a little aside, so that a plate can stand before it alone.
  s.lighting.lights = {{Kind::directional, {-1, 0, 0.75}}};
  s.lighting.shadows = s.lighting.volume_shadows = true;
  const auto brightness = [&] {
    const core::Image image = mesh.draw(s, 1);
    return double(image.pixel(0, 0)[0]) * double(image.pixel(0, 0)[3]);
  };
  const double gathered = 1 - std::exp(-2.0);
  EXPECT_NEAR(brightness(), gathered * (ambient + 0.8 * diffuse), 1e-3);
  // Light reaches the ray at x through (-1, z + 0.75 (x + 1)): a plate there hides x < 1/2.
  s.bodies = {plate({-1, 0.45, 0.55 + 0.75 * 1.0}, 0.375)};
  const double dark = 1 - std::exp(-2 * 0.5);
  EXPECT_NEAR(brightness(), dark * ambient + (gathered - dark) * (ambient + 0.8 * diffuse), 0.01);
  s.lighting.volume_shadows = false;
  EXPECT_NEAR(brightness(), gathered * (ambient + 0.8 * diffuse), 1e-3);
}

/// The same for single scattering: what is dark has no light at all.
TEST(VolumeShadow, SurfacesShadeScatteredLight) {
  RenderMesh mesh(4);
  const auto f = mesh.field("f", INSITU_VERTEX, one);
  FrameSettings s = one_ray(32);
  const double extinction = 0.4;
  s.volume = render::VolumeSettings{f, medium_of({1, 1, 1}, 0, opacity_of(extinction))};
  s.volume->unit_distance = 1;
  s.path_tracing->scattering = render::Scattering::single;
  s.path_tracing->samples = 64;
  s.lighting.lights = {{Kind::directional, {0, 0, 1}}};
  s.lighting.shadows = s.lighting.volume_shadows = true;
  // Radiance from [a, b] of the ray: pi / (4 pi) exp(-s x) s exp(-s 0.45), light from above.
  const auto truth = [&](double a, double b) {
    return 0.25 * std::exp(-0.45 * extinction) *
           (std::exp(-extinction * a) - std::exp(-extinction * b));
  };
  expect_mean(estimate(draw_paths(mesh, s), 0), truth(0, 1), "no plate");
  // A plate above the mesh over x < 0.6.
  render::TriangleList list;
  list.source = "roof";
  list.corners = {{-9, -9, 2}, {0.6, -9, 2}, {0.6, 9, 2}, {-9, -9, 2}, {0.6, 9, 2}, {-9, 9, 2}};
  s.bodies = {{std::make_shared<render::TriangleList>(list), 1, {0, 0, 0}}}; // sends no light
  const core::Image shaded = draw_paths(mesh, s);
  expect_mean(estimate(shaded, 0), truth(0.6, 1), "a plate");
  EXPECT_TRUE(same(shaded, draw_paths(mesh, s, nullptr, 3))); // any number of threads
  s.bodies[0].opacity = 0.75;
  expect_mean(estimate(draw_paths(mesh, s), 0), truth(0.6, 1) + 0.25 * truth(0, 0.6),
              "a plate that lets a quarter through");
  s.lighting.volume_shadows = false;
  expect_mean(estimate(draw_paths(mesh, s), 0), truth(0, 1), "passed by");
}

/// Scattered light that ends at walls of the dome's colour brings as much as the dome: nobody can
/// see the medium, nor the walls. At black walls it ends.
TEST(VolumeShadow, WhiteFurnaceWithWalls) {
  RenderMesh mesh(4, Shape::tetrahedron, 0.2);
  const auto f = mesh.field("f", INSITU_VERTEX, one);
  FrameSettings s = one_ray(16);
  s.volume = render::VolumeSettings{f, medium_of({1, 1, 1}, 0, opacity_of(4.0))};
  s.volume->unit_distance = 1;
  s.path_tracing->scattering = render::Scattering::multiple;
  s.path_tracing->shows_dome = true;
  s.lighting.lights = {{Kind::dome}};
  s.lighting.volume_shadows = true;
  for (const float opacity : {1.0f, 0.4f}) {
    s.bodies = {plate({0.6, 0.5, 0.5}, 0.3)}; // within the medium
    s.bodies[0].opacity = double(opacity);
    const core::Image image = draw_paths(mesh, s);
    for (int p = 0; p < 256; ++p)
      EXPECT_NEAR(image.pixel(p % 16, p / 16)[0], 1, 1e-5);
    s.bodies = {plate({0.6, 0.5, 0.5}, 0.3, {0, 0, 0})};
    s.bodies[0].opacity = double(opacity);
    const Estimate dark = estimate(draw_paths(mesh, s), 0);
    s.lighting.volume_shadows = false;
    const Estimate passed = estimate(draw_paths(mesh, s), 0);
    s.lighting.volume_shadows = true;
    EXPECT_LT(dark.mean + most_errors * (dark.error + passed.error), passed.mean);
  }
}

} // namespace
} // namespace insitu::test
