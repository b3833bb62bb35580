// When things happen: every, when, both, and what a cycle without them costs.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "coupled.h"

namespace {

using runs::Coupled;

std::set<int> cycles_in(const std::string& table) {
  const runs::Table t = runs::parse_table(table);
  std::set<int> cycles;
  for (std::size_t i = 0; i < t.rows.size(); ++i)
    cycles.insert(int(t.number(i, "cycle")));
  return cycles;
}

std::string probe(const std::string& name, const std::string& trigger) {
  return "  - {name: " + name + ", points: [[0.1, 0.1, 0.1]], fields: [pressure], " + trigger +
         "}\n";
}

double hottest(const sedov::Solver& solver) {
  return *std::max_element(solver.pressure.begin(), solver.pressure.end());
}

/// Mean and largest speed.
std::pair<double, double> speeds(const sedov::Solver& solver) {
  double sum = 0.0, most = 0.0;
  for (std::size_t i = 0; i < solver.u.size(); ++i) {
    const double s = std::sqrt(solver.u[i] * solver.u[i] + solver.v[i] * solver.v[i] +
                               solver.w[i] * solver.w[i]);
    sum += s;
    most = std::max(most, s);
  }
  return {sum / double(solver.u.size()), most};
}

TEST(Triggers, EveryAndWhen) {
  const test::Folder folder;
  // Values that the run passes halfway.
  sedov::Config config;
  config.cells.fill(10);
  sedov::Solver ahead(config);
  while (ahead.cycle() < 15)
    ahead.advance();
  const std::string pressure = std::to_string(hottest(ahead));
  const std::string speed = std::to_string(speeds(ahead).first);
  Coupled run(
      {.scene = "insitu: 1\nevery: 5\nprobes:\n" + probe("inherited", "accuracy: exact") +
                probe("often", "every: 2") + probe("hot", "when: max(pressure) < " + pressure) +
                probe("both", "every: 3, when: cycle >= 6 and not (time > 1)") +
                probe("never", "when: min(density) < 0") +
                probe("fast", "when: mean(velocity) > " + speed + " && max(velocity) > 0.1"),
       .output = folder.path()});
  std::set<int> hot, fast;
  const auto expect_of_this_cycle = [&] {
    if (hottest(run.solver) < std::stod(pressure))
      hot.insert(run.solver.cycle());
    const auto [mean, most] = speeds(run.solver);
    if (mean > std::stod(speed) && most > 0.1)
      fast.insert(run.solver.cycle());
  };
  ASSERT_TRUE(run.execute());
  expect_of_this_cycle();
  for (int cycle = 1; cycle <= 30; ++cycle) {
    ASSERT_TRUE(run.step()) << insitu_last_message();
    expect_of_this_cycle();
  }
  run.session.close();
  const runs::Files files = runs::files_of(folder.path());
  EXPECT_EQ(cycles_in(files.at("inherited.csv")), (std::set<int>{0, 5, 10, 15, 20, 25, 30}));
  EXPECT_EQ(cycles_in(files.at("often.csv")).size(), 16u);
  ASSERT_FALSE(hot.empty());
  ASSERT_LT(hot.size(), 31u);
  EXPECT_EQ(cycles_in(files.at("hot.csv")), hot);
  EXPECT_EQ(cycles_in(files.at("both.csv")), (std::set<int>{6, 9, 12, 15, 18, 21, 24, 27, 30}));
  EXPECT_EQ(files.count("never.csv"), 0u);
  ASSERT_FALSE(fast.empty());
  ASSERT_LT(fast.size(), 31u);
  EXPECT_EQ(cycles_in(files.at("fast.csv")), fast);
}

TEST(Triggers, FramesAreNamedByTheirCycle) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\nframes:\n"
                        "  - {name: f, size: [16, 16], volume: {field: density}, every: 4, "
                        "when: cycle != 4}\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute());
  run.run(9);
  EXPECT_EQ(runs::names_of(runs::files_of(folder.path())),
            (std::vector<std::string>{"data.csv", "f_000000.png", "f_000008.png", "index.html",
                                      "run.js"}));
  EXPECT_EQ(run.session.report().frames, 2);
}

TEST(Triggers, NothingIsDoneForASceneThatAsksForNothing) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\n", .output = folder / "absent"});
  ASSERT_TRUE(run.execute());
  run.run(3);
  run.session.close();
  EXPECT_EQ(folder.count(), 0u);
}

} // namespace
