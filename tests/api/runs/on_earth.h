#pragma once

#include <filesystem>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "insitu/insitu.hpp"

#include "coupled.h"
#include "fixtures/earth_meshes.h"

/// A coupled run for tests on a mesh of hexahedra in longitude, latitude and a vertical number.
namespace runs {

/// The Pacific on both sides of the date line.
inline insitu::fixtures::Lattice pacific() {
  return {.west = 150,
          .south = -30,
          .east = 210,
          .north = 30,
          .across = 12,
          .along = 12,
          .levels = {-3000, 0}};
}

/// Of a session with these items of a scene.
inline insitu::Options options_of(const std::string& items, const std::string& output,
                                  int threads) {
  insitu::Options o;
  o.scene_text = "insitu: 1\npage: false\n" + items;
  o.output = output;
  o.threads = threads;
  return o;
}

class OnEarth {
public:
  /// The lattice's units are the frame's. Fields: `latitude` (degrees) and `height` (metres), which
  /// cells interpolate to rounding, and `velocity`, zero at first.
  OnEarth(const insitu::fixtures::Lattice& lattice, const std::string& scene,
          const std::string& output, int threads = 1)
      : session(options_of(scene, output, threads)), mesh(session.mesh("ocean")) {
    const auto& units = lattice.units;
    mesh.frame(insitu::Frame::geodetic(
        units.down ? insitu::Vertical::down : insitu::Vertical::up,
        units.radians ? insitu::Angle::radians : insitu::Angle::degrees,
        units.kilometres ? insitu::Length::kilometres : insitu::Length::metres));
    remesh(lattice);
  }

  /// Other cells in the same units, in the place of those that were there.
  void remesh(const insitu::fixtures::Lattice& lattice) {
    const insitu::test::TestMesh from = insitu::fixtures::lattice(lattice);
    const auto& units = lattice.units;
    for (std::vector<double>* values : {&lon, &lat, &vertical, &latitude, &height})
      values->clear();
    connectivity.clear();
    for (const auto& p : from.vertices) {
      lon.push_back(p.x);
      lat.push_back(p.y);
      vertical.push_back(p.z);
      latitude.push_back(p.y * (units.radians ? 180 / std::numbers::pi : 1));
      height.push_back(p.z * units.up_per_unit());
    }
    for (const auto& cell : from.cells)
      connectivity.insert(connectivity.end(), cell.vertices.begin(), cell.vertices.begin() + 8);
    velocity.assign(3 * lon.size(), 0.0);
    mesh.points(lon, lat, vertical);
    mesh.hexahedra(connectivity);
    mesh.vertex_field("latitude", latitude);
    mesh.vertex_field("height", height);
    mesh.vertex_field("velocity", insitu::Array(velocity).components(3));
  }

  void flow(double east, double north) {
    for (std::size_t i = 0; i < lon.size(); ++i) {
      velocity[3 * i] = east;
      velocity[3 * i + 1] = north;
    }
    mesh.changed(insitu::fields);
  }

  std::vector<double> lon, lat, vertical, latitude, height, velocity;
  std::vector<std::int32_t> connectivity;
  insitu::Session session;
  insitu::Mesh mesh;
};

/// A run of 20 cycles in one, by execute(run, first, last), against one that is stopped after 10
/// (and went on to 13) and taken up again by three threads: the same files, which are returned.
template <class Execute>
Files in_one_and_in_two(const insitu::fixtures::Lattice& lattice, const std::string& scene,
                        Execute&& execute) {
  const test::Folder whole, parts, state;
  {
    OnEarth run(lattice, scene, whole.path());
    execute(run, 0, 20);
  }
  {
    OnEarth run(lattice, scene, parts.path());
    execute(run, 0, 10);
    run.session.checkpoint(state / "s");
    execute(run, 11, 13);
    std::filesystem::copy(parts.path(), state / "out", std::filesystem::copy_options::recursive);
  }
  {
    OnEarth run(lattice, scene, state / "out", 3);
    run.session.restart(state / "s");
    execute(run, 11, 20);
  }
  const Files files = files_of(whole.path());
  EXPECT_EQ(differences(files, files_of(state / "out")), std::vector<std::string>{});
  return files;
}

} // namespace runs
