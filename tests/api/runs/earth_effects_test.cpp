// Effects on particles of meshes in longitude and latitude in whole runs: at times between cycles,
// through periodic sides, and over a stop.
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>

#include "coupled.h"
#include "on_earth.h"

namespace {

using insitu::fixtures::Lattice;
using runs::OnEarth;

/// The Pacific on both sides of the date line.
Lattice pacific() {
  return {.west = 150,
          .south = -30,
          .east = 210,
          .north = 30,
          .across = 12,
          .along = 12,
          .levels = {-3000, 0}};
}

const std::string seeds =
    "seeds: [[178.5, 5, 0], [-179.9, -20, -700], [152, 29.9, -10], [208, 3, 0]]";

void execute(OnEarth& run, int first, int last) {
  for (int cycle = first; cycle <= last; ++cycle) {
    run.flow(2.5 + std::cos(0.4 * cycle), 1.5 * std::sin(0.4 * cycle) + 0.5);
    ASSERT_TRUE(run.session.execute(cycle, 50000.0 * cycle)) << insitu_last_message();
  }
}

/// A run of 20 cycles in one, against one that is stopped after 10 (and went on to 12) and taken
/// up again by three threads: the same files.
runs::Files in_one_and_in_two(const std::string& scene) {
  const test::Folder whole, parts, state;
  {
    OnEarth run(pacific(), scene, whole.path());
    execute(run, 0, 20);
  }
  {
    OnEarth run(pacific(), scene, parts.path());
    execute(run, 0, 10);
    run.session.checkpoint(state / "s");
    execute(run, 11, 12);
    std::filesystem::copy(parts.path(), state / "out", std::filesystem::copy_options::recursive);
  }
  {
    OnEarth run(pacific(), scene, state / "out", 3);
    run.session.restart(state / "s");
    execute(run, 11, 20);
  }
  const runs::Files files = runs::files_of(whole.path());
  EXPECT_EQ(runs::differences(files, runs::files_of(state / "out")), std::vector<std::string>{});
  return files;
}

TEST(EarthEffects, AtTimesBetweenCyclesAndOverAStop) {
  const std::string times = ", velocity: velocity, fields: [latitude, height], output: [csv, vtp], "
                            "times: {interval: 13000}, " +
                            seeds + ", effects: [";
  const runs::Files files =
      in_one_and_in_two("tracers:\n"
                        "  - {name: slides" +
                        times +
                        "{boundary: slide}, {settling: {speed: 0.001}}]}\n"
                        "  - {name: walks" +
                        times +
                        "{boundary: reflect}, {diffusion: {horizontal: 20000, vertical: 0.1}}]}\n"
                        "  - {name: flies" +
                        times +
                        "{boundary: slide}, {inertia: {response_time: 30000}}, "
                        "{coriolis: {rotation: [0, 0, 1e-5]}}]}\n"
                        "  - {name: undone" +
                        times + "{boundary: put_back}]}\n");
  for (const char* name : {"slides", "walks", "flies", "undone"}) {
    const runs::Table t = runs::parse_table(files.at(std::string(name) + ".csv"));
    EXPECT_GE(t.rows.size(), 4u * 76) << name << ": 13000 k up to 10^6, and endings";
    for (std::size_t i = 0; i < t.rows.size(); ++i) {
      if (t.text(i, "ending") == "killed")
        continue; // as the session closed, without fields
      EXPECT_EQ(t.text(i, "ending"), "alive") << name;
      EXPECT_EQ(std::fmod(t.number(i, "time"), 13000), 0.0);
      // Fields are known at every place, the latitude as the place says.
      EXPECT_NEAR(t.number(i, "latitude"), t.number(i, "y"), 1e-9) << name << i;
      EXPECT_NEAR(t.number(i, "height"), t.number(i, "z"), 1e-6) << name << i;
    }
  }
}

TEST(EarthEffects, ThroughPeriodicSidesAndOverAStop) {
  const std::string tracer = ", velocity: velocity, fields: [latitude, height], output: [csv, vtp, "
                             "netcdf], geodesics: [release_distance], " +
                             seeds + ", effects: [{boundary: {periodic: [x], other: slide}}";
  const runs::Files files =
      in_one_and_in_two("tracers:\n"
                        "  - {name: floats" +
                        tracer + "]}\n  - {name: walks" + tracer +
                        ", {diffusion: {horizontal: 20000, vertical: 0.1}}]}\n"
                        "  - {name: lines, kind: streamline, velocity: velocity, until: {length: "
                        "2e7}, spacing: {length: 1e5}, " +
                        seeds + ", effects: [{boundary: {periodic: [x], other: slide}}]}\n");
  for (const char* name : {"floats", "walks"}) {
    const runs::Table t = runs::parse_table(files.at(std::string(name) + ".csv"));
    EXPECT_EQ(t.rows.size(), 4u * 22) << name;
    int through = 0;
    for (std::size_t i = 0; i < t.rows.size(); ++i) {
      if (t.text(i, "ending") == "killed")
        continue; // as the session closed, without fields
      EXPECT_EQ(t.text(i, "ending"), "alive") << name;
      EXPECT_NEAR(t.number(i, "latitude"), t.number(i, "y"), 1e-9) << name << i;
      EXPECT_NEAR(t.number(i, "height"), t.number(i, "z"), 1e-6) << name << i;
      EXPECT_GE(t.number(i, "x"), 150) << name;
      EXPECT_LE(t.number(i, "x"), 210) << name;
      through += i >= 4 && t.number(i, "x") < t.number(i - 4, "x") - 30;
    }
    EXPECT_GE(through, 1) << name;
  }
}

} // namespace
