// When seeds begin, and that each particle is counted, whatever the releases.
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

TEST(Releases, TooManyAreRefused) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\ntracers: [{name: t, velocity: velocity, seeds: [[0.2, 0.2, "
                        "0.2]], release: {interval: 1e-12}}]\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute());
  EXPECT_FALSE(run.session.execute(1, 1.0));
  EXPECT_NE(std::string(insitu_last_message()).find("more than 1000000 releases"),
            std::string::npos)
      << insitu_last_message();
  EXPECT_EQ(run.session.report().particles_seeded, 1);
}

} // namespace
