// Flat meshes in scenes: tracers with closed orbits and walls, tables, frames that look onto the
// plane.
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
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
  for (const char* name : {"turns", "walls", "leaves", "spread"})
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
