// A run whose time goes back: steps replayed in reverse, with tracers of `direction: backward`.
#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>
#include <memory>

#include "coupled.h"
#include "flowing_cube.h"

namespace {

using namespace runs;

constexpr double dt = 0.1;

const char* const scene = R"(insitu: 1
page: false
tracers:
  - name: back
    direction: backward
    velocity: velocity
    fields: [density]
    seeds: {box: {min: [0.4, 0.4, 0.4], max: [0.6, 0.6, 0.6], counts: [2, 2, 2]}}
    integrator: {tolerance: 1e-11}
    output: [csv, vtp]
    every: 1
  - name: dense
    direction: backward
    velocity: velocity
    fields: [density]
    seeds: [[0.5, 0.5, 0.5]]
    times: {interval: 0.07, until: 0.2}
    integrator: {tolerance: 1e-11}
    output: [csv, vtp]
  - name: listed
    direction: backward
    velocity: velocity
    seeds: [[0.5, 0.5, 0.5]]
    times: [0.15, 0.33, 0.8]
    integrator: {tolerance: 1e-11}
  - name: streaks
    kind: streakline
    direction: backward
    velocity: velocity
    seeds: [[0.5, 0.4, 0.5]]
    release: {interval: 0.05, until: 0.5}
    until: {duration: 0.4}
    integrator: {tolerance: 1e-11}
    every: 1
  - {name: stays, velocity: velocity, seeds: [[0.5, 0.5, 0.5]]}
)";

struct Reversed {
  explicit Reversed(const std::string& output, int threads = 1, const char* more = "") {
    insitu::Options options;
    options.scene_text = std::string(scene) + more;
    options.output = output;
    options.threads = threads;
    options.log = [this](insitu::LogLevel, const char* message) { log.emplace_back(message); };
    session = insitu::Session(options);
    mesh = session.mesh("cube");
  }
  /// Cycles count on while time goes back from 0.8, or down as the replay counts them; new cells at
  /// every third.
  void run(int from, int to, bool down = false) {
    for (int cycle = from; cycle <= to; ++cycle) {
      const double time = 0.8 - cycle * dt;
      if (!cube || cycle % 3 == 0) {
        cube = std::make_unique<Cube>(4 + cycle / 3 % 2, cycle / 3 % 2 == 1, 0.2);
        cube->give(mesh, time);
      } else {
        cube->fill(time);
        cube->give_fields(mesh);
      }
      session.execute(down ? 20 - cycle : cycle, time);
      const insitu::Report r = session.report();
      std::int64_t sum = 0;
      for (const std::int64_t n : r.particles)
        sum += n;
      EXPECT_EQ(sum, r.particles_seeded);
    }
  }
  std::vector<std::string> log;
  std::unique_ptr<Cube> cube;
  insitu::Session session;
  insitu::Mesh mesh;
};

void expect_carried(const Table& table, const std::vector<Point>& seeds, double released,
                    double tolerance) {
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const double t = table.number(i, "time");
    const Point x = carried(seeds[std::size_t(table.number(i, "particle"))], released, t, 0.0);
    EXPECT_NEAR(table.number(i, "x"), x[0], tolerance) << i;
    EXPECT_NEAR(table.number(i, "y"), x[1], tolerance) << i;
    EXPECT_NEAR(table.number(i, "z"), x[2], tolerance) << i;
  }
}

// As insitu-replay --reverse counts: the first steps' files, of the highest cycles, are the last.
// What came after the checkpoint is taken back, and nothing of what came before.
TEST(BackwardRuns, GoOnFromACheckpointWhereCyclesGoDown) {
  const char* const more = R"(  - {name: kept, direction: backward, velocity: velocity,
     seeds: [[0.5, 0.5, 0.5]], output: [csv, netcdf], every: 1}
  - {name: grows, kind: streakline, direction: backward, velocity: velocity,
     seeds: [[0.5, 0.5, 0.5]], output: [netcdf], every: 1}
probes:
  - {name: gauge, points: [[0.5, 0.5, 0.5]], fields: [density], every: 1, output: [csv, netcdf]}
checkpoint: {every: 1, keep: 2}
)";
  const test::Folder whole;
  {
    Reversed run(whole.path(), 1, more);
    run.run(0, 8, true);
    run.session.close();
  }
  Files files = files_of(whole.path());
  EXPECT_TRUE(files.contains("checkpoint_000012.insitu"));
  EXPECT_TRUE(files.contains("checkpoint_000013.insitu"));
  EXPECT_EQ(std::ranges::count_if(files,
                                  [](const auto& f) { return f.first.starts_with("checkpoint_"); }),
            2);
  const Table gauge = parse_table(files.at("gauge.csv"));
  EXPECT_EQ(gauge.rows.size(), 9u);
  for (const int stop : {2, 4, 5}) {
    const test::Folder folder, state;
    {
      Reversed run(folder.path(), 1, more);
      run.run(0, stop, true);
      run.session.checkpoint(state / "s");
      run.run(stop + 1, stop + 2, true);
      run.session.close();
    }
    Reversed run(folder.path(), 2, more);
    run.session.restart(state / "s");
    // The solver's cells are those of the checkpoint until it makes new ones.
    run.cube = std::make_unique<Cube>(4 + stop / 3 % 2, stop / 3 % 2 == 1, 0.2);
    run.cube->give(run.mesh, 0.8 - stop * dt);
    run.run(stop + 1, 8, true);
    run.session.close();
    EXPECT_EQ(differences(files, files_of(folder.path())), std::vector<std::string>{}) << stop;
  }
}

TEST(BackwardRuns, TracksAreThoseOfTheFlow) {
  const test::Folder folder;
  Reversed run(folder.path());
  run.run(0, 8);
  run.session.close();
  std::vector<Point> seeds;
  for (int i = 0; i < 8; ++i)
    seeds.push_back({i & 1 ? 0.6 : 0.4, i & 2 ? 0.6 : 0.4, i & 4 ? 0.6 : 0.4});
  const Table back = parse_table(test::content(folder / "back.csv"));
  ASSERT_GE(back.rows.size(), 8u * 9u);
  expect_carried(back, seeds, 0.8, 1e-9);
  EXPECT_NEAR(back.number(back.rows.size() - 1, "time"), 0.0, 1e-15);

  // From 0.8 on each 0.07 back, until 0.2; and the listed ones in the order in which they come.
  const Table dense = parse_table(test::content(folder / "dense.csv"));
  ASSERT_GE(dense.rows.size(), 9u);
  expect_carried(dense, {{0.5, 0.5, 0.5}}, 0.8, 1e-7);
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_NEAR(dense.number(k, "time"), 0.8 - 0.07 * double(k), 1e-15);
    const double t = dense.number(k, "time");
    EXPECT_NEAR(dense.number(k, "density"), density(carried({0.5, 0.5, 0.5}, 0.8, t, 0.0), t),
                1e-6);
  }
  const Table listed = parse_table(test::content(folder / "listed.csv"));
  ASSERT_GE(listed.rows.size(), 3u);
  const double times[] = {0.8, 0.33, 0.15};
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_EQ(listed.number(k, "time"), times[k]);

  // Released at 0.8, 0.75, ... 0.5, and expired 0.4 later on their way.
  const Table streaks = parse_table(test::content(folder / "streaks.csv"));
  int expired = 0;
  for (std::size_t i = 0; i < streaks.rows.size(); ++i) {
    const double began = 0.8 - 0.05 * streaks.number(i, "particle"), t = streaks.number(i, "time");
    const Point x = carried({0.5, 0.4, 0.5}, began, t, 0.0);
    EXPECT_NEAR(streaks.number(i, "x"), x[0], 1e-8) << i;
    if (streaks.text(i, "ending") == "expired") {
      ++expired;
      EXPECT_NEAR(t, began - 0.4, 1e-12);
    }
  }
  EXPECT_EQ(expired, 7);

  // The indices of files have all times, and a tracer that goes forward waits.
  const auto entries = [&](const std::string& name) {
    const std::string text = test::content(folder / name);
    std::size_t count = 0;
    for (std::size_t at = 0; (at = text.find("<DataSet", at)) != std::string::npos; ++at)
      ++count;
    return count;
  };
  EXPECT_EQ(entries("back.pvd"), 9u);
  EXPECT_EQ(entries("dense.pvd"), 9u);
  EXPECT_FALSE(run.log.empty());
  for (const std::string& line : run.log)
    EXPECT_NE(line.find("tracer 'stays'"), std::string::npos) << line;
}

TEST(BackwardRuns, GoOnFromACheckpointToTheByteOnAnyThreads) {
  const test::Folder whole_folder;
  {
    Reversed run(whole_folder.path());
    run.run(0, 8);
    run.session.close();
  }
  const Files whole = files_of(whole_folder.path());
  for (const int stop : {4, 5}) { // other cells come at 6
    const test::Folder folder, state;
    {
      Reversed run(folder.path());
      run.run(0, stop);
      run.session.checkpoint(state / "s");
    }
    Reversed run(folder.path(), 2);
    run.cube = std::make_unique<Cube>(4 + stop / 3 % 2, stop / 3 % 2 == 1, 0.2);
    run.cube->give(run.mesh, 0.8 - stop * dt);
    run.session.restart(state / "s");
    run.run(stop + 1, 8);
    run.session.close();
    EXPECT_EQ(differences(whole, files_of(folder.path())), std::vector<std::string>{}) << stop;
  }
}

} // namespace
