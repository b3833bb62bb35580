// Cameras above places on Earth.
#include <cmath>
#include <gtest/gtest.h>

#include "geocentric_sea.h"

namespace insitu::test {
namespace {

double length(const Vec3d& v) {
  return std::sqrt(dot(v, v));
}

TEST(GeocentricCamera, StandsAbovePlaces) {
  const auto camera = [](const std::string& keys) {
    return scene::test::parse("frames: [{name: f, boundary: {}, geocentric: {}, camera: {" + keys +
                              "}}]")
        .frames[0]
        .camera;
  };
  const scene::Camera down = camera("longitude: -30, latitude: 40, altitude: 3e6");
  EXPECT_LT(length(*down.position - geocentric_place(-30, 40, 3e6)), 1e-6);
  EXPECT_LT(length(*down.look_at - geocentric_place(-30, 40, 0)), 1e-6);
  EXPECT_LT(length(down.up - scene::local_axes(-30, 40).north), 1e-12);
  const scene::Camera at =
      camera("longitude: -30, latitude: 10, altitude: 3e6, look_at: {longitude: -30, latitude: 40, "
             "height: 10}");
  EXPECT_LT(length(*at.look_at - geocentric_place(-30, 40, 10)), 1e-6);
  EXPECT_LT(length(at.up - scene::local_axes(-30, 10).up), 1e-12);
  const scene::Camera pole = camera("longitude: 0, latitude: 90, altitude: 1e6");
  EXPECT_LT(length(pole.up - Vec3d{-1, 0, 0}), 1e-12);
  const scene::Camera keyed = camera(
      "path: [{cycle: 0, longitude: 0, latitude: 0, altitude: 1e6}, {cycle: 9, longitude: 90, "
      "latitude: 0, altitude: 2e6}]");
  EXPECT_LT(length(*keyed.path[1].look_at - geocentric_place(90, 0, 0)), 1e-6);
}

TEST(GeocentricCamera, Errors) {
  const auto error = [](const std::string& keys) {
    return scene::test::error_of("frames: [{name: f, boundary: {}, " + keys + "}]");
  };
  EXPECT_NE(error("camera: {longitude: 1, latitude: 2, altitude: 3}").find("'geocentric'"),
            std::string::npos);
  EXPECT_NE(error("geocentric: {}, camera: {longitude: 1, altitude: 3}").find("latitude"),
            std::string::npos);
  EXPECT_NE(error("geocentric: {}, camera: {position: [1e7, 0, 0], longitude: 1, latitude: 2, "
                  "altitude: 3}")
                .find("either a position or longitude"),
            std::string::npos);
  EXPECT_NE(error("geocentric: {exaggeration: -1}").find("exaggeration"), std::string::npos);
}

/// The automatic camera: above the mesh's middle, north up, and all of it in the image.
TEST(GeocentricCamera, SeesTheWholeMeshFromAbove) {
  SeaRun run(boundary);
  const Drawn drawn(run, 100);
  const scene::Frame frame = scene::test::parse(boundary).frames[0];
  core::Context& context = run.context;
  scene::CinemaTable table({}, run.folder.string());
  scene::FieldReductions reductions(run.world, context.threads);
  const scene::Environment environment{
      context,        run.world,
      run.statistics, *const_cast<scene::FrameStructures*>(&drawn.structures),
      reductions,     table,
      "s.yaml",       run.folder.string()};
  const scene::FrameSettingsMaker maker(frame, environment);
  const render::Camera camera = maker.camera(frame.camera, {drawn.mesh.sampler().facts().bounds},
                                             {run.meshes, 0, 0.0, true, 0.0}, 0);
  Vec3d place = camera.position;
  geo::from_geocentric(geo::Frame::geodetic(), {&place, 1}, {&place, 1});
  EXPECT_NEAR(place.x, 15, 1);
  EXPECT_NEAR(place.y, 35, 1);
  EXPECT_GT(place.z, 1e6);
  const render::RayGenerator rays(camera, 100, 100);
  const auto pixel = [&](double lon, double lat) {
    return *rays.project(geocentric_place(lon, lat, 0));
  };
  for (const double lon : {west, west + extent})
    for (const double lat : {south, south + extent})
      for (const double at : pixel(lon, lat)) {
        EXPECT_GT(at, 0);
        EXPECT_LT(at, 100);
      }
  EXPECT_LT(pixel(15, 40)[1], pixel(15, 30)[1]) << "north is up";
  EXPECT_LT(pixel(10, 35)[0], pixel(20, 35)[0]) << "east is right";
}

} // namespace
} // namespace insitu::test
