// Steps held on several processes: what they answer is what one process's do, and what they did
// when they were live.
#include <cmath>

#include "fixtures/earth_meshes.h"
#include "shown_again.h"
#include "solvers.h"

using namespace insitu;
using namespace insitu::test;

namespace {

constexpr int cycles = 4;

const std::string items =
    "probes:\n"
    "  - {name: gauges, points: [[1, 1, 1], [2.1, 3.3, 0.7], [2, 2, 2], [9, 9, 9]], fields: [p, "
    "c], outside: nearest, output: [csv]}\n"
    "tracers:\n"
    "  - {name: lines, kind: streamline, velocity: u, seeds: [[1, 1, 1], [2, 3, 1]], until: "
    "{duration: 2}}\n"
    "  - {name: drifters, velocity: u, seeds: [[1, 1, 1]]}\n"
    "frames:\n"
    "  - {name: seen, size: [24, 24], isosurfaces: [{field: c, values: [0.5]}]}\n"
    "  - {name: inside, size: [24, 24], volume: {field: p}}\n";

TestMesh cubes() {
  MeshOptions grid;
  grid.size = 4;
  return make_mesh(grid, 3);
}

/// The solver's vertices move, or stand.
void move(PartSession& process, const TestMesh& whole, int cycle) {
  std::vector<Vec3d> points = whole.vertices;
  for (Vec3d& x : points)
    x += 0.03 * cycle * Vec3d{std::sin(x.y), 0.5 * x.z, std::cos(x.x)};
  if (!process.part().empty())
    process.part().move(process.mesh().mesh(), points);
}

/// Values at points that any process has, of the step that is live or shown.
std::vector<double> everywhere(api::Session& session, const char* field = "p") {
  std::vector<double> points, values(40);
  std::vector<std::int64_t> cells(40);
  for (int i = 0; i < 40; ++i)
    for (int a = 0; a < 3; ++a)
      points.push_back(i < 8 ? 1.0 + (i >> a & 1) : std::fmod((a + 1.3) * 0.77 * i, 4.2));
  const insitu_array at = insitu_array_of(points.data(), INSITU_FLOAT64, 40, 3);
  insitu_sample_args args = insitu_sample_args_default();
  args.locate.points = &at;
  args.locate.scope = INSITU_SCOPE_EVERYWHERE;
  args.locate.global_cells = cells.data();
  double* const to = values.data();
  args.fields = &field;
  args.values = &to;
  args.field_count = 1;
  session.sample(session.mesh("m"), args);
  for (double& value : values)
    value = value == value ? value : -1e9;
  for (const std::int64_t cell : cells)
    values.push_back(double(cell));
  return values;
}

} // namespace

TEST(ProcessHeld, StepsAreThoseOfOneProcessAndOfTheLiveOnes) {
  const TestMesh whole = cubes();
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\nhold: {steps: 3}\n" + items;
  for (const bool moves : {true, false}) {
    std::map<std::string, std::string> expected;
    std::vector<fixtures::Partition> partitions = fixtures::partitions(whole, 3);
    partitions.insert(partitions.begin(), fixtures::slabs(whole, 1));
    std::vector<std::vector<double>> answers; // of one process
    for (const fixtures::Partition& partition : partitions) {
      const OwnFolder folder;
      options.folder = folder / "out";
      run_processes(partition.processes, [&](parallel::World& world) {
        PartSession process(world, whole, partition, options);
        std::vector<std::vector<double>> live;
        for (int cycle = 0; cycle < cycles; ++cycle) {
          if (moves)
            move(process, whole, cycle);
          EXPECT_EQ(process.execute(cycle), "");
          live.push_back(everywhere(process.session()));
        }
        EXPECT_EQ(process.session().held(), (std::vector<std::int64_t>{1, 2, 3}));
        if (moves)
          move(process, whole, 9);
        process.give_fields(9);
        show_again(process.session(), {2, 1, 3, 1});
        for (const int cycle : {3, 1}) {
          process.session().show(cycle);
          EXPECT_EQ(everywhere(process.session()), live[std::size_t(cycle)]) << cycle;
        }
        EXPECT_EQ(process.session().finish(), "");
        if (!world.is_root())
          return;
        if (answers.empty())
          answers = live;
        EXPECT_EQ(answers, live) << partition.name;
      });
      const auto files = files_of(options.folder);
      if (expected.empty())
        expected = files;
      expect_same(expected, files, partition.name);
      EXPECT_EQ(expect_shown_as_live(files), 9);
    }
  }
}

/// Cells given by faces that move, flat cells, blocks of all kinds and an adaptive mesh.
TEST(ProcessHeld, OfAllKindsOfMeshes) {
  for (const SolverKind& kind : solver_kinds()) {
    std::map<std::string, std::string> expected;
    std::vector<std::vector<double>> answers; // of one process
    for (const int processes : {1, 4}) {
      const std::string which = kind.name + " on " + std::to_string(processes);
      const OwnFolder folder;
      const std::string out = folder / "out";
      run_processes(processes, [&](parallel::World& world) {
        SolverSession process(world, "insitu: 1\npage: false\nhold: {steps: 3}\n" + kind.actions,
                              out);
        process.take(kind.make(processes, world.rank()));
        const auto values = [&] { return everywhere(process.session(), kind.scalar.c_str()); };
        std::vector<std::vector<double>> live;
        for (int cycle = 0; cycle < cycles; ++cycle) {
          EXPECT_EQ(process.execute(cycle), "");
          live.push_back(values());
        }
        process.step(9);
        show_again(process.session(), {2, 1, 3, 1});
        for (const int cycle : {3, 1}) {
          process.session().show(cycle);
          EXPECT_EQ(values(), live[std::size_t(cycle)]) << which << ", " << cycle;
        }
        EXPECT_EQ(process.session().finish(), "");
        if (!world.is_root())
          return;
        if (answers.empty())
          answers = live;
        EXPECT_EQ(answers, live) << which;
      });
      const auto files = files_of(out);
      if (expected.empty())
        expected = files;
      expect_same(expected, files, which);
      EXPECT_EQ(expect_shown_as_live(files), 9) << which;
    }
  }
}

TEST(ProcessHeld, MeshesInLongitudeAndLatitude) {
  fixtures::Globe globe;
  globe.units = {false, true, false};
  globe.subdivisions = 2;
  const TestMesh whole = fixtures::globe(globe);
  PartSession::Options options;
  options.frame = fixtures::frame_of(globe.units);
  options.scene =
      "insitu: 1\npage: false\nhold: {steps: 2}\n"
      "frames: [{name: map, size: [32, 24], isosurfaces: [{field: p, values: [0.3]}]}]\n"
      "probes: [{name: seam, points: {box: {min: [-180, -90, -3.9], max: [180, 90, 0], "
      "counts: [13, 7, 2]}}, fields: [p, c]}]\n";
  std::map<std::string, std::string> expected;
  for (const int processes : {1, 3}) {
    const auto files = run_parts(whole, fixtures::slabs(whole, processes), options,
                                 [&](PartSession& process, parallel::World&) {
                                   for (int cycle = 0; cycle < 3; ++cycle)
                                     EXPECT_EQ(process.execute(cycle), "");
                                   show_again(process.session(), {1, 2, 1});
                                 });
    if (expected.empty())
      expected = files;
    expect_same(expected, files, std::to_string(processes));
    EXPECT_EQ(expect_shown_as_live(files), 2);
  }
}

/// All processes say the same, and go on.
TEST(ProcessHeld, WhatProcessesDoNotAgreeOnIsRefused) {
  const TestMesh whole = cubes();
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\n";
  run_processes(3, [&](parallel::World& world) {
    PartSession process(world, whole, fixtures::boxes(whole, 3), options);
    api::Session& session = process.session();
    const auto message = [&](auto&& call) {
      try {
        call();
      } catch (const parallel::AgreedError& e) {
        return std::string(e.what());
      }
      return std::string();
    };
    EXPECT_NE(message([&] { session.hold(1 + world.rank()); }).find("steps to hold"),
              std::string::npos);
    session.hold(2);
    for (const int cycle : {4, 5, 6})
      EXPECT_EQ(process.execute(cycle), "");
    EXPECT_NE(message([&] { session.show(4); }).find("cycle 4 is not held; those held are 5 6"),
              std::string::npos);
    EXPECT_NE(message([&] { session.show(world.rank() == 1 ? 5 : 6); }).find("cycle to show"),
              std::string::npos);
    session.show(5);
    session.show(INSITU_LIVE);
    EXPECT_EQ(process.execute(7), "");
    EXPECT_EQ(session.held(), (std::vector<std::int64_t>{6, 7}));
    EXPECT_EQ(session.finish(), "");
  });
}
