// The same run by other means gives the same bytes: threads, kind of mesh, refit or rebuild,
// builder.
#include <gtest/gtest.h>
#include <iostream>
#include <string>
#include <thread>

#include "coupled.h"

namespace {

using runs::Files;
using runs::Setup;

constexpr int cycles = 24;

// What does not look back at the earlier step.
const std::string of_one_step = R"(
probes:
  - name: grid
    points: {grid: {min: [-0.1, 0.01, 0.02], max: [1.25, 1.1, 1.0], counts: [17, 13, 11]}}
    every: 6
    output: [csv, vtp, json]
)";
const std::string streamlines = R"(
  - name: streamlines
    kind: streamline
    velocity: velocity
    fields: [density]
    seeds: {sphere: {center: [0.3, 0.3, 0.3], radius: 0.25, count: 40}}
    until: {duration: 0.2}
    every: 8
    output: [csv, vtp]
)";
const std::string paths = R"(
  - name: paths
    velocity: velocity
    fields: [pressure]
    seeds: {box: {min: [0.02, 0.02, 0.02], max: [1.3, 1.0, 1.0], counts: [9, 7, 5]}}
    every: 6
    output: [csv, vtp]
  - name: streaks
    kind: streakline
    velocity: velocity
    integrator: {method: rk4}
    seeds: [[0.1, 0.1, 0.1], [0.3, 0.2, 0.1]]
    every: 3
)";
const std::string frames = R"(
frames:
  - name: blast
    size: [96, 80]
    camera: {azimuth: 40, elevation: 28}
    volume: {field: density, colors: inferno, range: [0, 5], opacity: [[0, 0], [1.05, 0], [5, 0.7]]}
    scalar_bar: true
    time_label: true
    every: 12
  - name: shells
    size: [64, 64]
    isosurfaces: [{field: pressure, values: [0.05, 0.3], opacity: 0.6}]
    every: 12
  - name: traced
    size: [40, 36]
    camera: {azimuth: 40, elevation: 28}
    volume: {field: density, colors: inferno, range: [0, 5], opacity: [[0, 0], [1.05, 0], [5, 0.7]]}
    isosurfaces: [{field: pressure, values: [0.3]}]
    effects: [multiple_scattering, volume_shadows]
    lights: [{directional: [1, 0.5, 0.7]}, {dome: true}]
    path_tracing: {samples: 4, anisotropy: 0.4, accumulate: true}
    every: 12
)";

std::string scene(const std::string& locator = "auto") {
  return "insitu: 1\nlocator: {builder: " + locator + "}\n" + of_one_step +
         "tracers:" + streamlines + paths + frames;
}

void expect_same(const Files& a, const Files& b, const std::string& what) {
  for (const std::string& name : runs::differences(a, b))
    ADD_FAILURE() << what << ": '" << name << "' differs";
}

const Files& reference() {
  static const Files files = runs::run_to_files({.scene = scene()}, cycles);
  return files;
}

TEST(Identity, TheReferenceHoldsWhatTheSceneAsksFor) {
  const auto images = runs::names_of(reference(), ".png");
  EXPECT_EQ(images, (std::vector<std::string>{"blast_000000.png", "blast_000012.png",
                                              "blast_000024.png", "shells_000000.png",
                                              "shells_000012.png", "shells_000024.png",
                                              "traced_000000.png", "traced_000012.png",
                                              "traced_000024.png"}));
  EXPECT_NE(reference().at("traced_000000.png"), reference().at("traced_000024.png"));
  EXPECT_NE(reference().at("blast_000000.png"), reference().at("blast_000024.png"));
  EXPECT_NE(reference().at("shells_000000.png"), reference().at("shells_000024.png"));
  const runs::Table grid = runs::parse_table(reference().at("grid.csv"));
  EXPECT_EQ(grid.rows.size(), 5u * 17 * 13 * 11);
  EXPECT_EQ(runs::parse_table(reference().at("streamlines_000024.csv")).columns.front(), "line");
  EXPECT_FALSE(runs::parse_table(reference().at("paths.csv")).rows.empty());
  EXPECT_FALSE(runs::parse_table(reference().at("streaks.csv")).rows.empty());
}

TEST(Identity, AnyNumberOfThreads) {
  std::cout << "this machine runs " << std::thread::hardware_concurrency()
            << " threads at once; a session takes no more\n";
  for (const int threads : {2, 4, 0})
    expect_same(reference(), runs::run_to_files({.scene = scene(), .threads = threads}, cycles),
                std::to_string(threads) + " threads");
}

TEST(Identity, HexahedraAndAnImplicitBlock) {
  expect_same(reference(),
              runs::run_to_files({.scene = scene(), .threads = 2, .block = true}, cycles),
              "as a block");
}

TEST(Identity, EitherBuilder) {
  for (const char* builder : {"morton", "surface_area"})
    expect_same(reference(), runs::run_to_files({.scene = scene(builder)}, cycles), builder);
}

TEST(Identity, RefitAndRebuild) {
  // Pathlines are left out: at a change of topology they may not look back.
  const std::string text = "insitu: 1\n" + of_one_step + "tracers:" + streamlines + frames;
  const Files refitted = runs::run_to_files({.scene = text}, cycles);
  const Files rebuilt = runs::run_to_files({.scene = text}, cycles, insitu::everything);
  EXPECT_GT(refitted.size(), 10u);
  expect_same(refitted, rebuilt, "rebuilt at every cycle");
}

TEST(Identity, RefitsAndRebuildsAreWhatTheyWereToldToBe) {
  const test::Folder folder;
  runs::Coupled refitted({.scene = "insitu: 1\n", .output = folder.path()});
  refitted.execute();
  refitted.run(cycles);
  EXPECT_EQ(refitted.session.report().rebuilds + refitted.session.report().refits, cycles + 1);
  EXPECT_GT(refitted.session.report().refits, cycles / 2);
  runs::Coupled rebuilt({.scene = "insitu: 1\n", .output = folder.path()});
  rebuilt.execute();
  rebuilt.run(cycles, insitu::topology);
  EXPECT_EQ(rebuilt.session.report().rebuilds, cycles + 1);
  EXPECT_EQ(rebuilt.session.report().refits, 0);
}

} // namespace
