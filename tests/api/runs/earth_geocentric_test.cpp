// Effects on a mesh in geocentric metres in whole runs: what the scene calls down is down on Earth.
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "geo/reference_frames.h"
#include "on_earth.h"

namespace {

using insitu::math::Vec3d;
namespace geo = insitu::geo;

constexpr double omega = 1e-6; ///< of a flow about the Earth's axis, rad/s

/// A part of the Earth 4000 m deep, in geocentric metres, cells of a degree; it turns about the
/// axis, and halfway its cells become others.
struct Globe {
  Globe(const std::string& scene, const std::string& output, int threads)
      : session(runs::options_of(scene, output, threads)), mesh(session.mesh("ocean")) {
    mesh.frame(insitu::Frame::geocentric());
    remesh(8);
  }
  void remesh(int along) {
    const insitu::test::TestMesh from =
        insitu::fixtures::lattice({.west = 176,
                                   .south = 47,
                                   .east = 188,
                                   .north = 53,
                                   .across = 2 * along,
                                   .along = along,
                                   .levels = {-10000, -6000, -3000, 0},
                                   .jump = -360});
    const std::vector<Vec3d> points =
        geo::convert(geo::Frame::geodetic(), geo::Frame::geocentric(), from.vertices);
    for (auto& values : x)
      values.clear();
    velocity.clear();
    cells.clear();
    for (const Vec3d& p : points) {
      for (int a = 0; a < 3; ++a)
        x[std::size_t(a)].push_back(p[a]);
      velocity.insert(velocity.end(), {-omega * p.y, omega * p.x, 0.0});
    }
    for (const auto& cell : from.cells)
      cells.insert(cells.end(), cell.vertices.begin(), cell.vertices.begin() + 8);
    mesh.points(x[0], x[1], x[2]);
    mesh.hexahedra(cells);
    mesh.vertex_field("velocity", insitu::Array(velocity).components(3));
  }

  std::array<std::vector<double>, 3> x;
  std::vector<double> velocity;
  std::vector<std::int32_t> cells;
  insitu::Session session;
  insitu::Mesh mesh;
};

const std::string scene = R"(
tracers:
  - {name: drifts, velocity: velocity, frame: geodetic, seeds: &seeds [[179.9, 50, -2000], [178, 48.5, -3000], [-179, 52, -2500]]}
  - {name: sinks, velocity: velocity, frame: geodetic, seeds: *seeds, effects: [{settling: {speed: 0.01}}]}
  - {name: rises, velocity: velocity, frame: geodetic, seeds: *seeds, effects: [{settling: {velocity: [0, 0, 0.005]}}]}
  - {name: falls, velocity: velocity, frame: geodetic, seeds: *seeds,
     effects: [{inertia: {response_time: 100, gravity: [0, 0, -1e-4]}}]}
  - {name: walks, velocity: velocity, frame: geodetic, seeds: *seeds,
     effects: [{diffusion: {horizontal: 50}}]}
  - {name: mixes, velocity: velocity, frame: geodetic, seeds: *seeds,
     effects: [{diffusion: {horizontal: 50, vertical: 0.1}}, {boundary: slide}, {remove: {when: velocity < 0}}]}
)";

runs::Files run(int threads) {
  const test::Folder folder;
  {
    Globe globe(scene, folder.path(), threads);
    for (int cycle = 0; cycle <= 10; ++cycle) {
      if (cycle == 6) {
        globe.remesh(10);
        globe.mesh.changed(insitu::topology | insitu::geometry | insitu::fields);
      } else {
        globe.mesh.changed(insitu::fields);
      }
      EXPECT_TRUE(globe.session.execute(cycle, 1e4 * cycle)) << insitu_last_message();
    }
    const insitu::Report r = globe.session.report();
    EXPECT_EQ(r.particles[INSITU_END_ALIVE], 18);
    EXPECT_EQ(r.failures, 0);
  }
  return runs::files_of(folder.path());
}

TEST(EarthGeocentric, WhatTheSceneCallsDownIsDownOnEarth) {
  const runs::Files one = run(1);
  EXPECT_EQ(runs::differences(one, run(3)), std::vector<std::string>{});
  const double height[] = {-2000, -3000, -2500}, latitude[] = {50, 48.5, 52},
               longitude[] = {179.9, 178, -179};
  for (const char* name : {"drifts", "sinks", "rises", "falls", "walks", "mixes"}) {
    const std::string of = name;
    const runs::Table t = runs::parse_table(one.at(of + ".csv"));
    ASSERT_GE(t.rows.size(), 33u) << name;
    for (std::size_t i = 0; i < 33; ++i) {
      const double time = t.number(i, "time");
      const Vec3d x{t.number(i, "x"), t.number(i, "y"), t.number(i, "z")};
      Vec3d p;
      geo::convert(geo::Frame::geocentric(), geo::Frame::geodetic(), std::span(&x, 1),
                   std::span(&p, 1));
      const std::size_t k = i % 3;
      const double turned =
          std::remainder(p.x - longitude[k], 360.0) - omega * time * 180 / std::numbers::pi;
      if (of == "walks") { // by 50 m^2/s and 1e5 s, 5 deviations
        EXPECT_LT(std::abs(p.y - latitude[k]), 16e3 / 111e3);
      } else if (of != "mixes") {
        EXPECT_NEAR(p.y, latitude[k], of == "falls" ? 1e-3 : 1e-6) << name << i;
      }
      if (of == "drifts" || of == "sinks" || of == "rises") {
        EXPECT_NEAR(turned, 0.0, 1e-6) << name << i; // omega, whatever the height
      }
      // Stokes' terminal velocity, 0.01 m/s after 100 s. (The flow turns with 100 s of memory, and
      // is flung out by omega^2 R tau t = 64 m.)
      const double expected = height[k] - (of == "sinks"   ? 0.01 * time
                                           : of == "rises" ? -0.005 * time
                                           : of == "falls" ? 0.01 * (time - (time > 0 ? 100 : 0))
                                                           : 0.0);
      if (of == "falls") {
        EXPECT_NEAR(p.z, expected, 70) << i;
      } else if (of != "mixes") {
        EXPECT_NEAR(p.z, expected, 0.2) << name << i; // the tolerance's 1e-6 m/s
      }
    }
  }
}

} // namespace
