// Scenes on meshes in longitude and latitude over processes: the files of one process, to the byte.
#include <cmath>

#include "earths.h"
#include "part_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

void execute(const TestMesh& whole, PartSession& process, int cycles) {
  for (int cycle = 0; cycle < cycles; ++cycle) {
    if (!process.part().empty())
      process.part().give_field(process.mesh().mesh(), "w", INSITU_VERTEX, 3, flow(whole, cycle));
    EXPECT_EQ(process.execute(cycle), "");
  }
}

void expect_files_of_one(const std::string& scene, const std::vector<int>& sizes, int cycles,
                         const std::string& word) {
  for (const Earth& earth : earths()) {
    PartSession::Options options;
    options.scene = scene;
    options.frame = fixtures::frame_of(units);
    const Act act = [&](PartSession& process, parallel::World&) {
      execute(earth.mesh, process, cycles);
    };
    const auto expected = run_parts(earth.mesh, fixtures::slabs(earth.mesh, 1), options, act);
    std::string all;
    for (const auto& [name, text] : expected)
      all += name + text;
    EXPECT_NE(all.find(word), std::string::npos) << earth.name;
    for (const int processes : sizes) {
      const fixtures::Partition partition = processes == 2 ? fixtures::slabs(earth.mesh, 2)
                                            : processes == 3
                                                ? fixtures::empty_root(earth.mesh, 3)
                                                : fixtures::boxes(earth.mesh, processes);
      expect_same(expected, run_parts(earth.mesh, partition, options, act),
                  earth.name + ", " + partition.name + " on " + std::to_string(processes));
    }
  }
}

} // namespace

/// Probes with points on the seam, at the poles and a turn away, and what conditions reduce.
TEST(ProcessEarth, ProbesAndConditionsAreThoseOfOneProcess) {
  expect_files_of_one(
      "insitu: 1\npage: false\nprobes:\n"
      "  - {name: seam, points: {box: {min: [-360, -90, -3.9], max: [360, 90, 0.1], counts: [37, "
      "13, 3]}}, fields: [p, w, c], outside: nearest, output: [csv, netcdf]}\n"
      "  - {name: way, points: {transect: {from: [-170, 70, -0.1], to: [20, 75, -0.1], count: "
      "30}}, fields: [p], when: 'mean(p) > -1e9 and max(c) < 2'}\n",
      {2, 3, 4, 8}, 2, "seam.csv");
}

TEST(ProcessEarth, TracksAreThoseOfOneProcess) {
  const std::string more = ", fields: [p, w, c], geodesics: [path_length, release_distance, "
                           "release_bearing]";
  expect_files_of_one(
      std::string("insitu: 1\npage: false\ntracers:\n"
                  "  - {name: paths, velocity: w, kind: pathline, seeds: ") +
          seeds + more +
          ", output: [csv, vtp, netcdf], every: 2}\n"
          "  - {name: streaks, velocity: w, kind: streakline, seeds: {points: "
          "[[180, 10, -0.05], [-40, 85, -0.07], [10, -89.9, 0]]}, times: {interval: "
          "0.06}" +
          more + ", output: [csv, vtp]}\n",
      {2, 3, 4, 8}, 3, "killed");
}

TEST(ProcessEarth, EffectsAreThoseOfOneProcess) {
  expect_files_of_one(
      std::string("insitu: 1\npage: false\ntracers:\n"
                  "  - {name: walls, velocity: w, kind: pathline, seeds: ") +
          seeds +
          ", effects: [{boundary: {other: slide}}, {settling: {speed: 2000}}, {diffusion: "
          "{horizontal: 1e9, vertical: 1000}}], fields: [p], output: [csv]}\n"
          "  - {name: heavy, velocity: w, kind: pathline, seeds: " +
          seeds +
          ", effects: [{boundary: {other: reflect}}, {inertia: {response_time: 0.1, gravity: [0, "
          "0, -1]}}], fields: [p], output: [csv]}\n",
      {2, 4}, 3, "killed");
}

TEST(ProcessEarth, StreamlinesAreThoseOfOneProcess) {
  const auto lines = [](const std::string& name, const std::string& more) {
    return "  - {name: " + name + ", velocity: w, kind: streamline, seeds: " + seeds + more +
           ", until: {duration: 2}, fields: [p, c], output: [csv, vtp]}\n";
  };
  expect_files_of_one("insitu: 1\npage: false\ntracers:\n" + lines("both", ", direction: both") +
                          lines("even", ", spacing: {length: 3e5}") +
                          lines("walls", ", effects: [{boundary: {other: slide}}]"),
                      {2, 3, 4, 8}, 1, "walls");
}

/// Steps over the cells of several processes, over the seam and the poles.
TEST(ProcessEarth, FarStepsAreThoseOfOneProcess) {
  const std::string far = std::string(", velocity: w, fields: [p, w, c], seeds: ") + seeds +
                          ", integrator: {method: rk4, step: 0.5}";
  expect_files_of_one(
      "insitu: 1\npage: false\ntracers:\n"
      "  - {name: paths, kind: pathline, output: [csv], times: {interval: 0.06}" +
          far +
          "}\n"
          "  - {name: walls, kind: pathline, output: [csv], effects: [{boundary: "
          "{other: slide}}, {settling: {speed: 2000}}]" +
          far +
          "}\n"
          "  - {name: lines, kind: streamline, until: {duration: 2}, output: [csv]" +
          far + "}\n",
      {2, 3, 4, 8}, 3, "killed");
}

/// The solver moves cells from process to process, then takes another mesh, whose chart has its
/// seam elsewhere, and in the end the first one again.
TEST(ProcessEarth, OtherCellsAreThoseOfOneProcess) {
  const std::vector<Earth> all = earths();
  const auto by = [&](const TestMesh& from, const TestMesh& to) {
    return [&](PartSession& process, parallel::World& world) {
      const int processes = world.size();
      for (int cycle = 0; cycle < 5; ++cycle) {
        if (cycle == 2)
          process.deal(fixtures::dealt(from, processes, 3), world.rank(), &from);
        if (cycle == 3)
          process.deal(fixtures::boxes(to, processes), world.rank(), &to);
        if (cycle == 4)
          process.deal(fixtures::slabs(from, processes), world.rank(), &from);
        if (!process.part().empty())
          process.part().give_field(process.mesh().mesh(), "w", INSITU_VERTEX, 3,
                                    flow(cycle == 3 ? to : from, cycle));
        EXPECT_EQ(process.execute(cycle), "");
      }
    };
  };
  PartSession::Options options;
  options.frame = fixtures::frame_of(units);
  options.scene = "insitu: 1\npage: false\n" + tracers_and_walls;
  for (const auto& [from, to] : {std::pair(0, 1), std::pair(3, 2), std::pair(1, 3)}) {
    const TestMesh& whole = all[std::size_t(from)].mesh;
    const Act act = by(whole, all[std::size_t(to)].mesh);
    const auto expected = run_parts(whole, fixtures::slabs(whole, 1), options, act);
    EXPECT_NE(expected.at("paths.csv").find("killed"), std::string::npos);
    for (const int processes : {2, 3, 8})
      expect_same(expected, run_parts(whole, fixtures::boxes(whole, processes), options, act),
                  all[std::size_t(from)].name + " to " + all[std::size_t(to)].name + " on " +
                      std::to_string(processes));
  }
}

/// What leaves a basin at its eastern meridian comes in at the western one, wherever the seam is.
TEST(ProcessEarth, PeriodicSidesAreThoseOfOneProcess) {
  const auto tracer = [](const std::string& name, const std::string& of, const std::string& more) {
    return "  - {name: " + name + ", velocity: w, kind: " + of + ", fields: [p], output: [csv]" +
           ", seeds: {box: {min: [171, -50, -3.9], max: [206, 50, -0.5], counts: [7, 5, 2]}}" +
           more + "}\n";
  };
  PartSession::Options options;
  options.frame = fixtures::frame_of(units);
  options.scene =
      "insitu: 1\npage: false\ntracers:\n" +
      tracer("sliding", "pathline", ", effects: [{boundary: {periodic: [x], other: slide}}]") +
      tracer("walking", "pathline",
             ", effects: [{boundary: {periodic: [x], other: reflect}}, {diffusion: "
             "{horizontal: 1e9, vertical: 1000}}]") +
      tracer("lines", "streamline",
             ", effects: [{boundary: {periodic: [x], other: slide}}], until: "
             "{duration: 2}");
  for (const double jump : {0.0, -360.0}) {
    fixtures::Lattice basin;
    basin.units = units;
    basin.west = 170, basin.east = 207;
    basin.south = -60, basin.north = 60;
    basin.across = 12, basin.along = 10;
    basin.jump = jump;
    const TestMesh whole = lattice(basin);
    const Act act = [&](PartSession& process, parallel::World&) { execute(whole, process, 4); };
    const auto expected = run_parts(whole, fixtures::slabs(whole, 1), options, act);
    EXPECT_NE(expected.at("sliding.csv").find("killed"), std::string::npos);
    for (const int processes : {2, 4, 8})
      for (const fixtures::Partition& partition :
           {fixtures::slabs(whole, processes), fixtures::boxes(whole, processes)})
        expect_same(expected, run_parts(whole, partition, options, act),
                    partition.name + " on " + std::to_string(processes));
  }
}

/// Layers move up and down, and in the end all turns east, so that other cells wrap around.
TEST(ProcessEarth, ParticlesOfTheMaterialAreThoseOfOneProcess) {
  const std::string scene =
      std::string("insitu: 1\npage: false\ntracers:\n"
                  "  - {name: carried, attached: body, kind: pathline, fields: [p, c], geodesics: "
                  "[path_length], output: [csv, vtp], times: {interval: 0.1}, seeds: ") +
      seeds +
      "}\n"
      "  - {name: released, attached: body, kind: streakline, seeds: {points: [[180, 10, -0.05], "
      "[-40, 85, -0.07], [10, -89.9, -1], [359.9, 3, -2]]}, until: {duration: 0.6}, fields: [p], "
      "output: [csv]}\n";
  for (const Earth& earth : earths()) {
    PartSession::Options options;
    options.scene = scene;
    options.frame = fixtures::frame_of(units);
    const Act act = [&](PartSession& process, parallel::World&) {
      for (int cycle = 0; cycle < 6; ++cycle) {
        std::vector<Vec3d> points;
        for (const Vec3d& x : earth.mesh.vertices)
          points.push_back({cycle > 3 && std::abs(x.y) < 90
                                ? geo::longitude_from(-180, units, x.x + 17 * (cycle - 3))
                                : x.x,
                            x.y, x.z + 0.02 * cycle * std::sin(0.05 * x.y)});
        if (cycle > 0 && !process.part().empty())
          process.part().move(process.mesh().mesh(), points);
        EXPECT_EQ(process.execute(cycle), "");
      }
    };
    const auto expected = run_parts(earth.mesh, fixtures::slabs(earth.mesh, 1), options, act);
    EXPECT_NE(expected.at("carried.csv").find("killed"), std::string::npos) << earth.name;
    for (const int processes : {2, 4})
      expect_same(expected,
                  run_parts(earth.mesh, fixtures::boxes(earth.mesh, processes), options, act),
                  earth.name + " on " + std::to_string(processes));
  }
}

/// In longitude and latitude, with copies at the seam and the poles, and from space.
TEST(ProcessEarth, FramesAreThoseOfOneProcess) {
  expect_files_of_one(
      "insitu: 1\npage: false\nframes:\n"
      "  - {name: levels, size: [70, 66], images: [color, depth, cell],\n"
      "     isosurfaces: [{field: p, values: [0.5], normals: cell}], outline: {}}\n"
      "  - {name: rim, size: [70, 66], images: [color, depth, cell], boundary: {color: {field: "
      "c}, opacity: 0.5}, isosurfaces: [{field: p, values: [0.2], normals: central}]}\n"
      "  - {name: space, size: [80, 70], images: [color, depth, cell],\n"
      "     geocentric: {exaggeration: 100, globe: [0.62, 0.58, 0.48], graticule: 10},\n"
      "     camera: {longitude: 170, latitude: 40, altitude: 1.7e7, look_at: {longitude: 175, "
      "latitude: 50}},\n"
      "     boundary: {color: {field: c}}}\n"
      "  - {name: cut, size: [64, 64], geocentric: {exaggeration: 200},\n"
      "     camera: {longitude: -100, latitude: 30, altitude: 1e7, look_at: {longitude: -40, "
      "latitude: 36}},\n"
      "     isosurfaces: [{field: c, values: [0.3], normals: smooth}],\n"
      "     volume: {field: p, opacity: [[-1, 0], [1, 1]], unit_distance: 1.0e6}}\n"
      "  - {name: haze, size: [20, 20], geocentric: {exaggeration: 200},\n"
      "     camera: {longitude: -100, latitude: 30, altitude: 1e7, look_at: {longitude: -40, "
      "latitude: 36}},\n"
      "     volume: {field: p, opacity: [[-1, 0], [1, 1]], unit_distance: 1.0e6},\n"
      "     effects: [multiple_scattering], path_tracing: {samples: 2}}\n",
      {2, 3, 4, 8}, 1, "space_000000.png");
}

/// What takes the cells around a vertex, over the seam too, and volumes, which end where the chart
/// does.
TEST(ProcessEarth, VolumesAndAveragesInLongitudeAndLatitude) {
  expect_files_of_one(
      "insitu: 1\npage: false\nframes:\n"
      "  - {name: levels, size: [64, 64], images: [color, depth, cell], camera: {elevation: 60, "
      "fit: box},\n"
      "     isosurfaces: [{field: c, values: [0.2], normals: smooth}, {field: p, values: [0.5], "
      "normals: smooth, opacity: 0.6, color: {field: c}}],\n"
      "     volume: {field: p, opacity: [[0, 0], [2, 0.3]]}}\n"
      "  - {name: lit, size: [64, 40], camera: {azimuth: -90, elevation: 80},\n"
      "     volume: {field: c, smooth: true, shading: true, opacity: [[-1, 0], [1, 0.5]], "
      "unit_distance: 3}}\n"
      "  - {name: cells, size: [60, 40], images: [color, cell], camera: {azimuth: 180, elevation: "
      "10},\n"
      "     volume: {field: c, opacity: [[-1, 0], [1, 0.5]], unit_distance: 100}}\n"
      "  - {name: held, size: [40, 40], volume: {field: c, smooth: true, tolerance: 0.05, opacity: "
      "[[-1, 0], [1, 0.5]], unit_distance: 20}}\n"
      "  - {name: shadows, size: [40, 40], camera: {azimuth: 60, elevation: 40},\n"
      "     isosurfaces: [{field: p, values: [1], normals: smooth}], boundary: {opacity: 0.2},\n"
      "     volume: {field: p, opacity: [[0, 0], [5, 0.2]], shading: true, unit_distance: 50},\n"
      "     effects: [shadows, volume_shadows, {ambient_occlusion: {samples: 2}}]}\n"
      "  - {name: haze, size: [20, 20], volume: {field: p, opacity: [[-1, 0], [1, 0.5]], "
      "unit_distance: 60},\n"
      "     effects: [multiple_scattering], path_tracing: {samples: 2}}\n",
      {2, 3, 4}, 1, "levels_000000.png");
}
