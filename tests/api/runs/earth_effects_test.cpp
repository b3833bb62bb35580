// Effects on particles of meshes in longitude and latitude in whole runs: at times between cycles,
// through periodic sides, and over a stop.
#include <cmath>
#include <gtest/gtest.h>

#include "on_earth.h"

namespace {

using insitu::fixtures::Lattice;
using runs::OnEarth;
using runs::pacific;

const std::string seeds =
    "seeds: [[178.5, 5, 0], [-179.9, -20, -700], [152, 29.9, -10], [208, 3, 0]]";

void execute(OnEarth& run, int first, int last) {
  for (int cycle = first; cycle <= last; ++cycle) {
    run.flow(2.5 + std::cos(0.4 * cycle), 1.5 * std::sin(0.4 * cycle) + 0.5);
    ASSERT_TRUE(run.session.execute(cycle, 50000.0 * cycle)) << insitu_last_message();
  }
}

TEST(EarthEffects, AtTimesBetweenCyclesAndOverAStop) {
  const std::string times = ", velocity: velocity, fields: [latitude, height], output: [csv, vtp], "
                            "times: {interval: 13000}, " +
                            seeds + ", effects: [";
  const std::string scene =
      "tracers:\n"
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
      times + "{boundary: put_back}]}\n";
  const runs::Files files = runs::in_one_and_in_two(pacific(), scene, execute);
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
  const std::string scene =
      "tracers:\n"
      "  - {name: floats" +
      tracer + "]}\n  - {name: walks" + tracer +
      ", {diffusion: {horizontal: 20000, vertical: 0.1}}]}\n"
      "  - {name: lines, kind: streamline, velocity: velocity, until: {length: "
      "2e7}, spacing: {length: 1e5}, " +
      seeds + ", effects: [{boundary: {periodic: [x], other: slide}}]}\n";
  const runs::Files files = runs::in_one_and_in_two(pacific(), scene, execute);
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
