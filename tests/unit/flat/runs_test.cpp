// Flat meshes in scenes: tracers with closed orbits and walls, tables, frames that look onto the
// plane.
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <numbers>
#include <sstream>

#include "flat_meshes.h"
#include "output/image/png.h"
#include "unit/output/folder.h"

using namespace flat_meshes;

namespace {

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The columns of a table of numbers; text and empty cells are NaN.
std::map<std::string, std::vector<double>> table(const std::string& path) {
  std::istringstream in(content(path));
  std::string line, cell;
  std::vector<std::string> names;
  std::map<std::string, std::vector<double>> out;
  for (bool first = true; std::getline(in, line); first = false) {
    std::istringstream row(line + ",");
    for (std::size_t c = 0; std::getline(row, cell, ','); ++c) {
      char* end = nullptr;
      const double value = std::strtod(cell.c_str(), &end);
      if (first)
        names.push_back(cell);
      else
        out[names[c]].push_back(end == cell.c_str() ? std::nan("") : value);
    }
  }
  return out;
}

constexpr int n = 8;

struct Flow {
  Flow(const std::string& scene, Kind kind, const std::string& output, int components = 2,
       double plane = 0.0)
      : m(flat_mesh(n, kind, true)), arrays(m, kind) {
    insitu::Options options;
    options.scene_text = scene;
    options.output = output;
    options.log = [this](insitu::LogLevel level, const char* message) {
      if (level <= insitu::LogLevel::warning)
        log += message;
    };
    session = insitu::Session(options);
    mesh = session.mesh("m");
    arrays.give(mesh, kind);
    if (plane != 0.0) {
      xyz.clear();
      for (std::size_t v = 0; v < m.vertices(); ++v)
        xyz.insert(xyz.end(), {m.x[v], m.y[v], plane});
      mesh.points(insitu::Array(xyz.data(), m.vertices()));
    }
    for (std::size_t v = 0; v < m.vertices(); ++v) {
      velocity.insert(velocity.end(), {-(m.y[v] - 0.5 * n), m.x[v] - 0.5 * n});
      if (components == 3)
        velocity.push_back(1e3 + m.x[v]); // of no account
    }
    f = values_of(m);
    for (std::size_t c = 0; c < m.cells.size(); ++c)
      number.push_back(double(c));
    mesh.vertex_field("u", insitu::Array(velocity).components(components));
    mesh.vertex_field("f", insitu::Array(f));
    mesh.cell_field("number", insitu::Array(number));
  }
  Flat m;
  Arrays arrays;
  std::vector<double> velocity, f, number, xyz;
  std::string log;
  insitu::Session session;
  insitu::Mesh mesh;
};

const char* const vortex = R"(insitu: 1
page: false
tracers:
  - {name: turns, velocity: u, seeds: [[6, 4, 0], [4, 1.5, 50], [2.25, 5.5, -3]], integrator: {method: dopri5, tolerance: 1e-11}, fields: [f], output: [csv]}
  - {name: walls, velocity: u, seeds: [[7.75, 7.5, 0]], effects: [{boundary: slide}], output: [csv]}
  - {name: blown, velocity: u, seeds: [[4, 4, 0]], effects: [{windage: {field: u, factor: 0.01}}], output: [csv]}
  - {name: leaves, velocity: u, seeds: [[7.75, 7.5, 0]], output: [csv]}
  - {name: spread, velocity: u, seeds: [[4, 4, 0]], effects: [{diffusion: {horizontal: 0.05, vertical: 100, seed: 1}}, {boundary: reflect}], output: [csv]}
)";

std::map<std::string, std::string> vortex_files(Kind kind, int components, double plane,
                                                std::string* log = nullptr) {
  const test::Folder folder;
  Flow run(vortex, kind, folder.path(), components, plane);
  for (int cycle = 0; cycle <= 4; ++cycle)
    EXPECT_TRUE(run.session.execute(cycle, 0.5 * std::numbers::pi * cycle))
        << insitu_last_message();
  run.session.close();
  if (log)
    *log = run.log;
  std::map<std::string, std::string> files;
  for (const char* name : {"turns", "walls", "blown", "leaves", "spread"})
    files[name] = content(folder / (std::string(name) + ".csv"));
  return files;
}

} // namespace

TEST(FlatRuns, TracersOfAVortexComeBackAndStayInThePlane) {
  for (const Kind kind : {Kind::triangles, Kind::quads, Kind::mixed}) {
    const test::Folder folder;
    Flow run(vortex, kind, folder.path(), 2, 2.5);
    for (int cycle = 0; cycle <= 4; ++cycle)
      ASSERT_TRUE(run.session.execute(cycle, 0.5 * std::numbers::pi * cycle))
          << insitu_last_message();
    run.session.close();
    EXPECT_EQ(run.log, "");
    const auto turns = table(folder / "turns.csv");
    const double x[] = {6, 4, 2.25}, y[] = {4, 1.5, 5.5};
    int back = 0;
    for (std::size_t row = 0; row < turns.at("x").size(); ++row) {
      EXPECT_EQ(turns.at("z")[row], 2.5);
      const auto p = std::size_t(turns.at("particle")[row]);
      ASSERT_LT(p, 3u);
      EXPECT_NEAR(std::hypot(turns.at("x")[row] - 4, turns.at("y")[row] - 4),
                  std::hypot(x[p] - 4, y[p] - 4), 1e-9); // the tolerance times the turns
      if (std::isnan(turns.at("f")[row]))                // the row that tells how it ended
        continue;
      EXPECT_NEAR(turns.at("f")[row], linear(turns.at("x")[row], turns.at("y")[row]), 1e-12);
      if (turns.at("cycle")[row] == 4) {
        EXPECT_NEAR(turns.at("x")[row], x[p], 1e-9);
        EXPECT_NEAR(turns.at("y")[row], y[p], 1e-9);
        ++back;
      }
    }
    EXPECT_EQ(back, 3);
    const auto walls = table(folder / "walls.csv"), spread = table(folder / "spread.csv");
    for (const auto* of : {&walls, &spread})
      for (std::size_t row = 0; row < of->at("x").size(); ++row) {
        EXPECT_EQ(of->at("z")[row], 2.5);
        EXPECT_GE(of->at("x")[row], 0.0);
        EXPECT_LE(of->at("x")[row], double(n));
        EXPECT_GE(of->at("y")[row], 0.0);
        EXPECT_LE(of->at("y")[row], double(n));
      }
    EXPECT_EQ(walls.at("cycle").back(), 4.0);
  }
}

TEST(FlatRuns, AThirdComponentOfTheVelocityIsOfNoAccount) {
  std::string log;
  const auto two = vortex_files(Kind::mixed, 2, 2.5, &log);
  EXPECT_EQ(log, "");
  EXPECT_EQ(two, vortex_files(Kind::mixed, 3, 2.5));
}

TEST(FlatRuns, FramesLookOntoThePlane) {
  const test::Folder folder;
  const char* const scene = R"(insitu: 1
page: false
probes:
  - {name: p, points: [[1.5, 2.5, 100]], fields: [f, number]}
frames:
  - {name: boundary, size: [64, 64], images: [color, cell], camera: {orthographic: true, fit: box}, boundary: {color: {field: f}}}
  - {name: standard, size: [64, 64], images: [color, cell], boundary: {color: {field: f}}}
  - {name: volume, size: [64, 64], volume: {field: f}}
  - {name: iso, size: [64, 64], isosurfaces: [{field: f, values: [-5]}]}
  - {name: paths, size: [16, 16], volume: {field: f}, path_tracing: {samples: 4}}
)";
  Flow run(scene, Kind::quads, folder.path());
  ASSERT_TRUE(run.session.execute(0, 0.0)) << insitu_last_message();
  run.session.close();
  EXPECT_EQ(run.log, "");
  const auto p = table(folder / "p.csv");
  EXPECT_NEAR(p.at("f")[0], linear(1.5, 2.5), 1e-13);
  const auto image = insitu::output::read_png(folder / "boundary_000000.png");
  ASSERT_EQ(image.width, 64);
  // Colours change along x and y alike from the one corner to the other.
  std::map<std::array<int, 3>, int> colors;
  const std::size_t channels = image.pixels.size() / (64 * 64);
  for (std::size_t i = 0; i < 64 * 64; ++i)
    ++colors[{image.pixels[i * channels], image.pixels[i * channels + 1],
              image.pixels[i * channels + 2]}];
  EXPECT_GT(colors.size(), 50u);
}

TEST(FlatRuns, OtherCellsFromStepToStepAndACheckpoint) {
  const char* const scene = R"(insitu: 1
page: false
tracers:
  - {name: turns, velocity: u, seeds: [[6, 4, 0], [4, 1.5, 50], [2.25, 5.5, -3]], integrator: {method: dopri5, tolerance: 1e-11}, output: [csv]}
)";
  // The whole run; the same with a break after two steps.
  std::string whole;
  const Kind kinds[] = {Kind::triangles, Kind::quads, Kind::mixed};
  const auto give = [&](insitu::Mesh& mesh, int cycle, Flow& of) {
    of.arrays.give(mesh, kinds[cycle % 3]);
    mesh.vertex_field("u", insitu::Array(of.velocity).components(2));
    mesh.vertex_field("f", insitu::Array(of.f));
    mesh.cell_field("number", insitu::Array(of.number));
  };
  const auto go = [&](Flow& flow, std::vector<std::unique_ptr<Flow>>& others, int from, int to) {
    for (int cycle = from; cycle <= to; ++cycle) {
      others.push_back(std::make_unique<Flow>("", kinds[cycle % 3], ""));
      give(flow.mesh, cycle, *others.back());
      ASSERT_TRUE(flow.session.execute(cycle, 0.5 * std::numbers::pi * cycle))
          << insitu_last_message();
    }
  };
  const test::Folder once, twice;
  std::vector<std::unique_ptr<Flow>> others;
  {
    Flow flow(scene, Kind::quads, once.path());
    go(flow, others, 0, 4);
    flow.session.close();
    EXPECT_EQ(flow.log, "");
  }
  const auto turns = table(once / "turns.csv");
  for (std::size_t row = 0; row < turns.at("x").size(); ++row) {
    const double x[] = {6, 4, 2.25}, y[] = {4, 1.5, 5.5};
    const auto p = std::size_t(turns.at("particle")[row]);
    EXPECT_NEAR(std::hypot(turns.at("x")[row] - 4, turns.at("y")[row] - 4),
                std::hypot(x[p] - 4, y[p] - 4), 1e-9);
  }
  {
    Flow flow(scene, Kind::quads, twice.path());
    go(flow, others, 0, 2);
    flow.session.checkpoint(twice / "state");
  }
  {
    Flow flow(scene, Kind::quads, twice.path());
    flow.session.restart(twice / "state");
    go(flow, others, 3, 4);
    flow.session.close();
  }
  EXPECT_EQ(content(once / "turns.csv"), content(twice / "turns.csv"));
}

TEST(FlatRuns, OnTheGlobe) {
  constexpr int ni = 36, nj = 12; // from 60 degrees south to 60 degrees north, all around
  std::vector<double> lonlat, u, f;
  std::vector<int> ids;
  for (int j = 0; j <= nj; ++j)
    for (int i = 0; i < ni; ++i) {
      lonlat.insert(lonlat.end(), {10.0 * i, 10.0 * j - 60});
      u.insert(u.end(), {100.0, 0.0});
      f.push_back(10.0 * j - 60);
    }
  for (int j = 0; j < nj; ++j)
    for (int i = 0; i < ni; ++i) {
      const int v = i + ni * j, w = (i + 1) % ni + ni * j;
      ids.insert(ids.end(), {v, w, w + ni, v + ni});
    }
  const test::Folder folder;
  insitu::Options options;
  options.output = folder.path();
  std::string log;
  options.log = [&](insitu::LogLevel level, const char* message) {
    if (level <= insitu::LogLevel::warning)
      log += message;
  };
  options.scene_text = R"(insitu: 1
page: false
tracers:
  - {name: drifters, velocity: u, seeds: [[350, 20, 0]], integrator: {method: dopri5, tolerance: 1e-6}, output: [csv]}
frames:
  - {name: globe, size: [64, 64], geocentric: {}, camera: {longitude: 0, latitude: 0, altitude: 20000000}, boundary: {color: {field: f}}}
  - {name: map, size: [64, 64], boundary: {color: {field: f}}}
)";
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("m");
  mesh.flat_points(insitu::Array(lonlat.data(), f.size()));
  mesh.quads(ids);
  mesh.vertex_field("u", insitu::Array(u).components(2));
  mesh.vertex_field("f", insitu::Array(f));
  insitu_frame frame = insitu_frame_default();
  frame.kind = INSITU_FRAME_GEODETIC;
  ASSERT_EQ(insitu_mesh_frame(mesh.handle(), &frame), INSITU_OK);
  for (int cycle = 0; cycle < 2; ++cycle)
    ASSERT_TRUE(session.execute(cycle, 1e5 * cycle)) << insitu_last_message();
  session.close();
  EXPECT_EQ(log, "");
  const auto drifters = table(folder / "drifters.csv");
  // 1e7 m east at 20 degrees north of the ellipsoid.
  const double e2 = 0.00669437999014, lat = 20 * std::numbers::pi / 180;
  const double radius = 6378137.0 / std::sqrt(1 - e2 * std::pow(std::sin(lat), 2)) * std::cos(lat);
  const double lon = 350 + 1e7 / radius * 180 / std::numbers::pi - 360;
  std::size_t row = 0;
  while (drifters.at("cycle")[row] != 1)
    ++row;
  EXPECT_NEAR(std::remainder(drifters.at("x")[row] - lon, 360), 0, 1e-6); // a tenth of a metre
  EXPECT_NEAR(drifters.at("y")[row], 20, 1e-9);
  EXPECT_EQ(drifters.at("z")[row], 0);
  for (const char* name : {"globe", "map"}) {
    const auto image = insitu::output::read_png(folder / (std::string(name) + "_000000.png"));
    const std::size_t channels = image.pixels.size() / (64 * 64),
                      middle = (32 * 64 + 32) * channels;
    int others = 0; // than the corner's background
    for (std::size_t i = 0; i < 64 * 64; ++i)
      others += image.pixels[i * channels] != image.pixels[0];
    EXPECT_GT(others, 800) << name;
    EXPECT_NE(image.pixels[middle], image.pixels[0]) << name;
  }
}
