#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "fixtures/earth_meshes.h"

/// Meshes in longitude and latitude that processes share, and what flows over them.
namespace insitu::test {

struct Earth {
  std::string name;
  TestMesh mesh;
};

/// Heights are kilometres, so that maps are no towers.
inline const geo::ChartUnits units{false, true, false};

/// Cells that wrap around; poles at vertices; poles within cells.
inline std::vector<Earth> earths() {
  fixtures::Lattice ring;
  ring.units = units;
  ring.wraps = true;
  ring.jump = -360;
  ring.west = 0, ring.east = 360;
  ring.south = -80, ring.north = 80;
  ring.across = 18, ring.along = 10;
  fixtures::Globe on_vertices, within_cells;
  on_vertices.units = within_cells.units = units;
  on_vertices.subdivisions = within_cells.subdivisions = 2;
  within_cells.tilt = 0.3;
  fixtures::Lattice basin = ring;
  basin.wraps = false;
  basin.jump = 0;
  basin.west = 100, basin.east = 260;
  return {{"basin", lattice(basin)},
          {"ring", lattice(ring)},
          {"globe with vertices at the poles", globe(on_vertices)},
          {"globe with cells at the poles", globe(within_cells)}};
}

/// Some 500 km a cycle, over the seam and the poles.
inline std::vector<double> flow(const TestMesh& whole, int cycle) {
  std::vector<double> w;
  for (const Vec3d& x : whole.vertices) {
    const double lon = x.x * std::numbers::pi / 180, lat = x.y * std::numbers::pi / 180;
    w.insert(w.end(), {1.5e6 * std::cos(lat) * (1 + 0.1 * cycle) + 8e5 * std::cos(lon),
                       1.6e6 * std::sin(lon + 0.2 * cycle), 300 * std::sin(3 * lon)});
  }
  return w;
}

/// Of tracers over all of the earth.
inline const char* const seeds =
    "{box: {min: [-180, -90, -3.9], max: [180, 90, 0], counts: [9, 7, 1]}}";

/// Tracers that go on from cells to other cells, through the water and along its walls.
inline const std::string tracers_and_walls =
    std::string("tracers:\n"
                "  - {name: paths, velocity: w, kind: pathline, fields: [p, w, c], geodesics: "
                "[path_length], output: [csv], seeds: ") +
    seeds +
    "}\n"
    "  - {name: walls, velocity: w, kind: pathline, seeds: " +
    seeds +
    ", effects: [{boundary: {other: slide}}, {settling: {speed: 2000}}, {diffusion: {horizontal: "
    "1e9, vertical: 1000}}], fields: [p], output: [csv]}\n";

} // namespace insitu::test
