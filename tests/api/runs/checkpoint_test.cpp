// A run that stops and one that goes on from its checkpoint write, together, the files that a run
// without a stop writes, to the byte.
#include <filesystem>
#include <gtest/gtest.h>

#include "coupled.h"

namespace {

using runs::Coupled;

const std::string scene = R"(
insitu: 1
page: false
probes:
  - {name: gauges, points: [[0.1, 0.1, 0.1], [0.3, 0.3, 0.2], [9, 9, 9]], every: 3, output: [csv, netcdf]}
  - {name: marks, attached: body, points: [[0.11, 0.13, 0.17], [9, 9, 9], [0.2, 0.15, 0.1]], every: 3,
     output: [csv, netcdf, vtp, json]}
tracers:
  - name: paths
    velocity: velocity
    fields: [density]
    seeds: {box: {min: [-0.1, 0.05, 0.05], max: [1.3, 1.15, 1.15], counts: [8, 5, 5]}}
    until: {length: 0.05}
    output: [csv, netcdf, vtp]
    every: 4
  - name: streaks
    kind: streakline
    velocity: velocity
    seeds: {probe: gauges}
    until: {duration: 0.02}
    output: [csv, netcdf]
    every: 3
  - name: timed
    velocity: velocity
    seeds: [[0.2, 0.1, 0.1]]
    release: {interval: 0.0007}
    every: 100
  - name: curved
    velocity: velocity
    time_interpolation: cubic
    seeds: {box: {min: [0.1, 0.1, 0.1], max: [0.4, 0.4, 0.4], counts: [3, 3, 3]}}
    effects: [{windage: {field: velocity, factor: 0.1}}]
    every: 5
  - name: dense
    velocity: velocity
    fields: [density]
    seeds: [[0.2, 0.1, 0.1], [0.3, 0.3, 0.2]]
    release: {interval: 0.004}
    until: {duration: 0.01}
    times: {interval: 0.0011}
    output: [csv, netcdf, vtp]
  - name: walkers
    velocity: velocity
    seeds: {box: {min: [0.1, 0.1, 0.1], max: [1.1, 1.1, 1.1], counts: [3, 3, 3]}}
    effects: [{diffusion: {coefficient: 0.01}}, {boundary: reflect}]
    every: 5
  - name: heavy
    velocity: velocity
    seeds: {box: {min: [0.1, 0.1, 0.1], max: [1.1, 1.1, 1.1], counts: [3, 3, 3]}}
    effects: [{inertia: {response_time: 0.01}}]
    integrator: {tolerance: 1e-4}
    every: 5
  - name: carried
    attached: body
    seeds: [[0.1, 0.1, 0.1], [0.2, 0.15, 0.1]]
    every: 5
  - {name: lines, kind: streamline, velocity: velocity, seeds: [[0.2, 0.2, 0.2], [9, 9, 9]], every: 7}
)";

/// Advances the solver alone: what a solver's own checkpoint would do.
void skip_to(Coupled& run, int cycle) {
  while (run.solver.cycle() < cycle)
    run.solver.advance();
}

runs::Files uninterrupted(const runs::Setup& from, int cycles) {
  return runs::run_to_files(from, cycles);
}

/// A run to `last`, killed there (nothing is closed), with a checkpoint after `stop`; then one from
/// there to `cycles`, with as many threads as asked for.
runs::Files interrupted(runs::Setup setup, int stop, int last, int cycles, int threads) {
  const test::Folder folder, copy;
  setup.output = folder.path();
  const std::string file = copy / "state";
  {
    Coupled run(setup);
    EXPECT_TRUE(run.execute()) << insitu_last_message();
    run.run(stop);
    run.session.checkpoint(file);
    const insitu::Report before = run.session.report();
    run.run(last);
    // What a kill at this moment leaves.
    std::filesystem::copy(folder.path(), copy / "out", std::filesystem::copy_options::recursive);
    EXPECT_GT(before.particles_seeded, 0);
  }
  setup.output = copy / "out";
  setup.threads = threads;
  Coupled run(setup);
  skip_to(run, stop);
  run.session.restart(file);
  run.run(cycles);
  run.session.close();
  return runs::files_of(copy / "out");
}

TEST(Checkpoint, TracksGoOnToTheByte) {
  for (const bool block : {false, true}) {
    const runs::Setup setup{.scene = scene, .block = block};
    const runs::Files whole = uninterrupted(setup, 30);
    ASSERT_GT(whole.at("paths.nc").size(), 10000u);
    // At 0 and 2 fewer steps are known than the cubic takes.
    for (const auto& [stop, last, threads] :
         {std::tuple(10, 10, 1), {12, 17, 2}, {0, 5, 1}, {2, 5, 1}}) {
      SCOPED_TRACE("stopped at " + std::to_string(stop) + ", killed at " + std::to_string(last));
      EXPECT_EQ(runs::differences(whole, interrupted(setup, stop, last, 30, threads)),
                std::vector<std::string>{});
    }
  }
}

// A job that ends with a checkpoint closes its session, which kills its particles: the next one
// takes that back.
TEST(Checkpoint, TracksGoOnFromAClosedSession) {
  const runs::Setup setup{.scene = scene};
  const runs::Files whole = uninterrupted(setup, 30);
  const test::Folder folder, state;
  runs::Setup parts = setup;
  parts.output = folder.path();
  for (const auto& [from, to] : {std::pair(0, 12), {12, 17}, {17, 30}}) {
    Coupled run(parts);
    skip_to(run, from);
    if (from > 0) {
      run.session.restart(state / "s");
    } else {
      ASSERT_TRUE(run.execute()) << insitu_last_message();
    }
    run.run(to);
    run.session.checkpoint(state / "s");
    run.session.close();
  }
  EXPECT_EQ(runs::differences(whole, runs::files_of(folder.path())), std::vector<std::string>{});
}

// The test above would see it if the step before were not known after the restart.
TEST(Checkpoint, WithoutTheStepBeforeTracksDiffer) {
  const runs::Setup setup{.scene = scene};
  const test::Folder folder;
  runs::Setup other = setup;
  other.output = folder.path();
  {
    Coupled run(other);
    ASSERT_TRUE(run.execute());
    run.run(10);
    run.session.checkpoint(folder / "state");
  }
  Coupled run(other);
  skip_to(run, 10);
  // Other cells, in the order of their numbers: the step before is of cells that are no more.
  for (std::size_t i = 0; i < 8; ++i)
    std::swap(run.solver.connectivity[i], run.solver.connectivity[8 + i]);
  run.session.restart(folder / "state");
  ASSERT_TRUE(run.step()) << insitu_last_message();
  run.session.close();
  const runs::Files whole = uninterrupted(setup, 11);
  EXPECT_NE(test::content(folder / "timed.csv"), whole.at("timed.csv"));
}

TEST(Checkpoint, OfTheSceneIsWrittenWhenDueAndOldOnesGo) {
  const test::Folder folder;
  const std::string text = scene + "checkpoint: {every: 5, keep: 2}\n";
  const runs::Files whole = uninterrupted({.scene = text}, 23);
  {
    Coupled run({.scene = text, .output = folder.path()});
    ASSERT_TRUE(run.execute());
    run.run(18);
    EXPECT_EQ(runs::names_of(runs::files_of(folder.path()), ".insitu"),
              (std::vector<std::string>{"checkpoint_000010.insitu", "checkpoint_000015.insitu"}));
  }
  Coupled run({.scene = text, .output = folder.path()});
  skip_to(run, 15);
  run.session.restart(folder / "checkpoint_000015.insitu");
  EXPECT_GT(run.session.report().particles_seeded, 275) << "counted as before the stop";
  run.run(23);
  run.session.close();
  const runs::Files resumed = runs::files_of(folder.path());
  EXPECT_EQ(whole.count("checkpoint_000020.insitu"), 1u) << "compared with the others, to the byte";
  EXPECT_EQ(runs::differences(whole, resumed), std::vector<std::string>{});
}

TEST(Checkpoint, ThatIsNotOfThisSceneIsRefusedAndTheRunGoesOn) {
  const test::Folder folder;
  runs::Setup setup{.scene = scene, .output = folder / "a"};
  const std::string file = folder / "state";
  {
    Coupled run(setup);
    EXPECT_THROW(run.session.checkpoint(file), insitu::Error) << "before the first execute";
    ASSERT_TRUE(run.execute());
    run.session.checkpoint(file);
    run.solver.advance();
    run.mesh.changed(insitu::fields);
    EXPECT_EQ(insitu_session_checkpoint(run.session.handle(), file.c_str()), INSITU_ERROR_ORDER);
    EXPECT_EQ(insitu_session_restart(run.session.handle(), file.c_str()), INSITU_ERROR_ORDER);
    EXPECT_EQ(insitu_session_checkpoint(run.session.handle(), nullptr), INSITU_ERROR_ARGUMENT);
  }
  const std::string whole = test::content(file);
  const auto refused = [&](const std::string& content, const std::string& why,
                           const std::string& with = scene) {
    test::put(file, content);
    Coupled run({.scene = with, .output = folder / "b"});
    EXPECT_EQ(insitu_session_restart(run.session.handle(), file.c_str()), INSITU_ERROR_FILE);
    const std::string message = insitu_last_message();
    EXPECT_NE(message.find(why), std::string::npos) << message;
    EXPECT_NE(message.find(file), std::string::npos) << message;
    EXPECT_TRUE(run.execute()) << "the solver goes on: " << insitu_last_message();
    EXPECT_EQ(run.session.report().particles[INSITU_END_KILLED], 0);
  };
  refused("", "no checkpoint");
  refused("cycle,time\n0,0\n", "no checkpoint");
  refused(whole.substr(0, whole.size() - 1), "bytes after its head");
  refused(whole.substr(0, 30), "no checkpoint");
  for (const std::size_t at : {std::size_t(50), whole.size() / 2, whole.size() - 1}) {
    std::string damaged = whole;
    damaged[at] = char(damaged[at] ^ 4);
    refused(damaged, "damaged");
  }
  std::string later = whole;
  later[8] = 77;
  refused(later, "version 77");
  std::string other = scene;
  other.replace(other.find("name: timed"), 11, "name: times");
  refused(whole, "'timed'", other);
  Coupled run({.scene = scene, .output = folder / "b"});
  EXPECT_EQ(insitu_session_restart(run.session.handle(), (folder / "absent").c_str()),
            INSITU_ERROR_FILE);
  EXPECT_NE(std::string(insitu_last_message()).find("absent"), std::string::npos);
}

} // namespace
