// When seeds begin, and that each particle is counted, whatever the releases.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <set>

#include "coupled.h"

namespace {

using runs::Coupled;

/// The first row of each particle.
std::map<int, std::size_t> first_rows(const runs::Table& t) {
  std::map<int, std::size_t> first;
  for (std::size_t i = 0; i < t.rows.size(); ++i)
    first.try_emplace(int(t.number(i, "particle")), i);
  return first;
}

TEST(Releases, AtCyclesAndAtTimes) {
  const test::Folder folder;
  const auto tracer = [](const std::string& name, const std::string& keys) {
    return "  - {name: " + name + ", velocity: velocity, " + keys + "}\n";
  };
  Coupled run({.scene = "insitu: 1\nprobes:\n  - {name: gauges, points: [[0.2, 0.2, 0.2], "
                        "[9, 9, 9]], every: 100}\ntracers:\n" +
                        tracer("once", "seeds: {probe: gauges}") +
                        tracer("cycles", "seeds: {probe: gauges}, release: {every: 3}") +
                        tracer("times", "seeds: [[0.2, 0.2, 0.2], [0.4, 0.1, 0.1]], release: "
                                        "{interval: 0.001, until: 0.02}, until: {duration: 0.01}"),
               .output = folder.path()});
  std::vector<double> times;
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  times.push_back(run.solver.time());
  while (run.solver.time() < 0.03) {
    ASSERT_TRUE(run.step()) << insitu_last_message();
    times.push_back(run.solver.time());
    const insitu::Report r = run.session.report();
    EXPECT_EQ(std::accumulate(std::begin(r.particles), std::end(r.particles), std::int64_t(0)),
              r.particles_seeded);
    const auto rounds = std::int64_t(std::floor(std::min(times.back(), 0.02) / 0.001)) + 1;
    EXPECT_EQ(r.particles_seeded, 2 + 2 * (run.solver.cycle() / 3 + 1) + 2 * rounds)
        << run.solver.cycle();
  }
  run.session.close();
  EXPECT_EQ(first_rows(runs::parse_table(test::content(folder / "once.csv"))).size(), 2u);
  const runs::Table cycles = runs::parse_table(test::content(folder / "cycles.csv"));
  for (const auto& [particle, row] : first_rows(cycles)) {
    EXPECT_EQ(cycles.number(row, "cycle"), 3 * (particle / 2));
    EXPECT_EQ(cycles.text(row, "ending"), particle % 2 ? "seed_outside" : "alive");
  }
  // A particle that began at k intervals expires a duration after that, to the last digits: so it
  // began between the cycles.
  const runs::Table timed = runs::parse_table(test::content(folder / "times.csv"));
  std::map<int, double> ends;
  std::set<int> ended;
  for (std::size_t i = 0; i < timed.rows.size(); ++i) {
    const int particle = int(timed.number(i, "particle"));
    EXPECT_EQ(ended.count(particle), 0u) << "a number used again, or a row after the end";
    if (timed.text(i, "ending") == "expired") {
      ended.insert(particle);
      ends[particle] = timed.number(i, "time");
    }
  }
  ASSERT_EQ(ends.size(), 42u) << "released at 0, 0.001, ... 0.02";
  for (const auto& [particle, end] : ends)
    EXPECT_NEAR(end, (particle / 2) * 0.001 + 0.01, 1e-15) << particle;
}

// Seeds of a probe, released where a condition holds: once, at its first time; at multiples of a
// cycle; at times, of which those of other cycles are left out.
TEST(Releases, WhereAConditionHolds) {
  const test::Folder folder;
  const auto tracer = [](const std::string& name, const std::string& release) {
    return "  - {name: " + name + ", velocity: velocity, seeds: {probe: gauges}, release: {" +
           release + "}, output: [csv, netcdf]}\n";
  };
  const auto densest_of = [](const Coupled& run) {
    return *std::max_element(run.solver.density.begin(), run.solver.density.end());
  };
  Coupled before({});
  before.run(6);
  const double threshold = 0.5 * (densest_of(before) + 1); // at rest it is 1
  Coupled run({.scene = "insitu: 1\nprobes:\n  - {name: gauges, points: [[0.2, 0.2, 0.2]], every: "
                        "100}\ntracers:\n" +
                        tracer("first", "when: max(density) > " + std::to_string(threshold)) +
                        tracer("late", "when: cycle >= 4, until: -1") +
                        tracer("cycles", "every: 2, when: cycle > 3 and cycle != 8") +
                        tracer("times", "interval: 0.001, when: cycle >= 5"),
               .output = folder.path()});
  std::vector<double> densest, times;
  const auto note = [&] {
    times.push_back(run.solver.time());
    densest.push_back(densest_of(run));
  };
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  note();
  for (int cycle = 1; cycle <= 12; ++cycle) {
    ASSERT_TRUE(run.step()) << insitu_last_message();
    note();
  }
  run.session.close();
  const auto released = [&](const std::string& name) { // the cycle of each particle's first row
    std::vector<int> cycles;
    const runs::Table t = runs::parse_table(test::content(folder / (name + ".csv")));
    for (const auto& [particle, row] : first_rows(t)) {
      EXPECT_EQ(particle, int(cycles.size()));
      cycles.push_back(int(t.number(row, "cycle")));
    }
    return cycles;
  };
  const auto holds = std::find_if(densest.begin(), densest.end(), [&](double d) {
    return d > std::stod(std::to_string(threshold));
  });
  ASSERT_NE(holds, densest.begin());
  ASSERT_NE(holds, densest.end());
  EXPECT_EQ(released("first"), std::vector<int>{int(holds - densest.begin())});
  EXPECT_EQ(released("late"), std::vector<int>{}) << "not after its time";
  EXPECT_EQ(released("cycles"), (std::vector<int>{4, 6, 10, 12}));
  std::vector<int> wanted; // multiples of 0.001 that lie between the cycles from 5 on
  for (int cycle = 5; cycle <= 12; ++cycle)
    for (int k = 0; k < 1000; ++k) {
      const double at = times[0] + k * 0.001;
      if (at > times[std::size_t(cycle) - 1] && at <= times[std::size_t(cycle)])
        wanted.push_back(cycle);
    }
  ASSERT_GT(wanted.size(), 2u);
  EXPECT_EQ(released("times"), wanted);
}

TEST(Releases, TooManyAreRefused) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\ntracers: [{name: t, velocity: velocity, seeds: [[0.2, 0.2, "
                        "0.2]], release: {interval: 1e-12}}]\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute());
  EXPECT_FALSE(run.session.execute(1, 1.0));
  EXPECT_NE(std::string(insitu_last_message()).find("at most 1000000"),
            std::string::npos)
      << insitu_last_message();
  EXPECT_EQ(run.session.report().particles_seeded, 1);
}

// The log says at each due cycle what became of the particles, with the endings that there are.
TEST(Releases, AreAccountedForInTheLog) {
  const test::Folder folder;
  std::vector<std::string> log;
  insitu::Options options;
  options.scene_text =
      "insitu: 1\npage: false\ntracers:\n  - {name: t, velocity: velocity, every: 2, "
      "release: {every: 1}, seeds: [[0.2, 0.2, 0.2], [9, 9, 9]]}\n";
  options.output = folder.path();
  options.log_level = insitu::LogLevel::info;
  options.log = [&](insitu::LogLevel, const char* message) { log.emplace_back(message); };
  Coupled run({});
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("hydro");
  mesh.points(run.solver.x, run.solver.y, run.solver.z);
  mesh.hexahedra(run.solver.connectivity);
  mesh.vertex_field("velocity", {run.solver.u, run.solver.v, run.solver.w});
  for (int cycle = 0; cycle < 3; ++cycle) {
    ASSERT_TRUE(session.execute(cycle, run.solver.time())) << insitu_last_message();
    run.solver.advance();
    mesh.changed(insitu::geometry | insitu::fields);
  }
  std::vector<std::string> lines;
  for (const std::string& line : log)
    if (line.find("tracer 't'") != std::string::npos)
      lines.push_back(line);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "cycle 0: tracer 't': 2 seeded = 1 alive + 1 seed_outside");
  EXPECT_EQ(lines[1], "cycle 2: tracer 't': 6 seeded = 3 alive + 3 seed_outside");
}

} // namespace
