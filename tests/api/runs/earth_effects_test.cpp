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

// Along the equator, at the surface: longitude goes by u / a.
TEST(EarthEffects, WindageRemovalAndAgeOverTheDateLine) {
  const test::Folder folder;
  {
    const std::string of = ", velocity: velocity, seeds: [[178.5, 0, 0]], ";
    OnEarth run(pacific(),
                "tracers:\n  - {name: blown" + of +
                    "effects: [{windage: {field: velocity, factor: 0.5}}]}\n  - {name: sunk" + of +
                    "effects: [{settling: {speed: 0.0005}}, {remove: {when: height < -60}}]}\n"
                    "  - {name: aged, kind: streakline" +
                    of +
                    "effects: [{age_limit: 125000}]}\n  - {name: line, kind: streamline, every: "
                    "5" +
                    of +
                    "effects: [{windage: {field: velocity, factor: 0.5}}, {remove: {when: age > "
                    "30000}}]}\n",
                folder.path());
    for (int cycle = 0; cycle <= 5; ++cycle) {
      run.flow(2, 0);
      ASSERT_TRUE(run.session.execute(cycle, 50000.0 * cycle)) << insitu_last_message();
    }
  }
  const auto longitude = [](double speed, double t, double height) {
    return 178.5 + speed * t / (6378137 + height) * 180 / std::numbers::pi;
  };
  const auto table = [&](const std::string& name) {
    return runs::parse_table(test::content(folder / (name + ".csv")));
  };
  const runs::Table blown = table("blown"), sunk = table("sunk"), aged = table("aged"),
                    line = table("line_000005");
  for (std::size_t i = 0; i < blown.rows.size(); ++i)
    EXPECT_NEAR(blown.number(i, "x"), longitude(3, blown.number(i, "time"), 0), 1e-7);
  EXPECT_GT(blown.number(blown.rows.size() - 1, "x"), 185);
  // At the end of the cycle in which it is so deep: at 150000 s.
  const std::size_t last = sunk.rows.size() - 1;
  EXPECT_EQ(sunk.text(last, "ending"), "removed");
  EXPECT_EQ(sunk.number(last, "time"), 150000);
  EXPECT_NEAR(sunk.number(last, "z"), -75, 1e-6);
  EXPECT_NEAR(sunk.number(last, "x"), longitude(2, 150000, -37.5), 1e-7);
  int expired = 0;
  for (std::size_t i = 0; i < aged.rows.size(); ++i)
    if (aged.text(i, "ending") == "expired") {
      ++expired;
      EXPECT_EQ(aged.number(i, "time"), 50000 * aged.number(i, "particle") + 125000);
      EXPECT_NEAR(aged.number(i, "x"), longitude(2, 125000, 0), 1e-7);
    }
  EXPECT_EQ(expired, 3);
  EXPECT_EQ(line.text(0, "ending"), "removed");
  EXPECT_NEAR(line.number(line.rows.size() - 1, "x"), longitude(3, 30000, 0), 1e-6);
}

TEST(EarthEffects, BodiesGoWithLayersThatMove) {
  const test::Folder folder;
  {
    const std::string at = ": [[178.5, 5, -600], [-179.5, -20, -1500]], attached: body";
    OnEarth run(pacific(),
                "tracers:\n  - {name: marks, seeds" + at + "}\nprobes:\n  - {name: gauges, points" +
                    at + ", fields: [height]}\n",
                folder.path());
    for (int cycle = 0; cycle <= 4; ++cycle) {
      for (std::size_t i = 0; cycle > 0 && i < run.vertical.size(); ++i)
        run.vertical[i] = run.height[i] * (1 + 0.1 * cycle); // `height` is what they were
      run.mesh.changed(insitu::geometry);
      ASSERT_TRUE(run.session.execute(cycle, 50000.0 * cycle)) << insitu_last_message();
    }
  }
  const runs::Table marks = runs::parse_table(test::content(folder / "marks.csv")),
                    gauges = runs::parse_table(test::content(folder / "gauges.csv"));
  ASSERT_EQ(gauges.rows.size(), 10u);
  ASSERT_GE(marks.rows.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    const double depth = i % 2 ? -1500 : -600;
    EXPECT_NEAR(marks.number(i, "z"), depth * (1 + 0.1 * double(i / 2)), 1e-9);
    EXPECT_NEAR(marks.number(i, "x"), i % 2 ? 180.5 : 178.5, 1e-12);
    EXPECT_EQ(marks.text(i, "cell"), marks.text(i % 2, "cell"));
    EXPECT_NEAR(gauges.number(i, "height"), depth, 1e-9);
    for (const char* column : {"x", "y", "z"})
      EXPECT_EQ(gauges.text(i, column), marks.text(i, column));
    for (const char* column : {"cell", "r", "s", "t"})
      EXPECT_EQ(gauges.text(i, column), gauges.text(i % 2, column));
  }
}

} // namespace
