// Memory that one process lacks, in each phase of a collective call: all processes say the same,
// and nobody hangs (the test's limit of time is the check). What is taken is counted at operator
// new, so that each piece of a noteworthy size fails once, on one process or another.
#include "fixtures/lacking_memory.h"
#include "part_session.h"

namespace {

thread_local std::int64_t until_failure = -1; ///< pieces that are still had; -1: all

} // namespace

bool insitu::test::lacks(std::size_t bytes) {
  return until_failure >= 0 && bytes >= least_bytes && !is_exchanging && until_failure-- == 0;
}

using namespace insitu;
using namespace insitu::test;

namespace {

constexpr int processes = 3;

/// One process of a run in which a piece of memory is lacking.
struct Attempt {
  PartSession& process;
  parallel::World& world;
  const TestMesh& whole;
  const OwnFolder& folder;
  int failing;         ///< the process
  std::int64_t pieces; ///< that it still has
  bool failed = false;

  /// A collective call, which returns what went wrong or throws it.
  template <class Call>
  void operator()(Call&& call) {
    std::string said;
    until_failure = world.rank() == failing ? pieces : -1;
    try {
      said = call();
    } catch (const parallel::AgreedError& e) {
      said = e.what();
    }
    failed = world.rank() == failing && until_failure < 0;
    until_failure = -1;
    world.require_same([&] { return std::vector<parallel::Named>{{"said", said}}; });
    std::int64_t any = failed;
    world.reduce(std::span(&any, 1), parallel::Reduction::greatest);
    failed = any != 0;
    if (!said.empty()) { // else it did without, as a sort may
      EXPECT_TRUE(failed) << said;
      EXPECT_NE(said.find("process " + std::to_string(failing) + " of 3: out of memory"),
                std::string::npos)
          << said;
    }
  }
};

/// Runs body(attempt) with `step` pieces more each time, on each process in turn, until none is
/// lacking. Returns how often one was.
template <class Body>
int lack_each(const std::string& scene, int step, Body&& body) {
  if (const char* given = std::getenv("INSITU_LACK_STEP"))
    step = std::atoi(given);
  const TestMesh whole = jittered_cubes(3);
  int failures = 0, in_vain = 0;
  for (int n = 0; in_vain < processes && !testing::Test::HasFailure(); ++n) {
    const OwnFolder folder;
    PartSession::Options options;
    options.scene = "insitu: 1\npage: false\n" + scene;
    options.folder = folder / "out";
    bool failed = false;
    run_processes(processes, [&](parallel::World& world) {
      PartSession process(world, whole, fixtures::boxes(whole, processes), options);
      Attempt attempt{process, world,         whole,
                      folder,  n % processes, std::int64_t(n / processes) * step};
      body(attempt);
      EXPECT_EQ(process.session().finish(), "");
      if (world.is_root())
        failed = attempt.failed;
    });
    failures += failed;
    in_vain = failed ? 0 : in_vain + 1;
  }
  return failures;
}

std::string execute(PartSession& process, int cycle) {
  return process.session().execute(cycle, 0.25 * cycle);
}

const std::string moving =
    "probes:\n  - {name: marks, attached: body, points: {box: {min: [0, 0, 0], max: [4, 4, 4], "
    "counts: [4, 4, 4]}}, fields: [u], output: [json]}\n"
    "tracers:\n  - {name: paths, velocity: u, seeds: {box: {min: [0.5, 0.5, 0.5], max: [4.5, 4.5, "
    "4.5], counts: [4, 3, 3]}}, fields: [p, c], output: [csv, vtp]}\n";

} // namespace

TEST(ProcessFailures, MemoryThatLacksInAnyPhaseOfAFrame) {
  const int failures = lack_each(
      "frames:\n  - {name: seen, size: [70, 70], volume: {field: p}, isosurfaces: [{field: p, "
      "values: [2], opacity: 0.5, normals: smooth}, {field: p, values: [3], normals: central}], "
      "boundary: {opacity: 0.1, color: {field: "
      "c}}}\n  - {name: held, size: [8, 8], volume: {field: p, tolerance: 0.1}}\n",
      167, [](Attempt& attempt) {
        EXPECT_EQ(attempt.process.execute(0), "");
        attempt.process.give_fields(1);
        attempt([&] { return execute(attempt.process, 1); });
        EXPECT_EQ(attempt.process.execute(2), "");
      });
  EXPECT_GT(failures, 10);
}

/// Of a second mesh, which the root lacks: volumes that overlap, and rays of light that meet what
/// both have.
TEST(ProcessFailures, MemoryThatLacksInAnyPhaseOfAFrameOfSeveralMeshes) {
  const int failures = lack_each(
      "frames:\n  - {name: both, size: [20, 20], effects: [shadows, volume_shadows], lights: "
      "[{directional: [1, 1, 2]}], meshes: [\n"
      "     {mesh: m, volume: {field: p, shading: true}, isosurfaces: [{field: p, values: [2], "
      "opacity: 0.5, normals: smooth}]},\n"
      "     {mesh: n, volume: {field: p}, boundary: {opacity: 0.1, color: {field: c}}, "
      "isosurfaces: [{field: p, values: [3], normals: central}]}]}\n",
      37, [](Attempt& attempt) {
        TestMesh whole = attempt.whole;
        for (Vec3d& x : whole.vertices)
          x += Vec3d{0.7, 0.6, 0.5};
        FurtherMesh n(attempt.process, "n", whole, fixtures::empty_root(whole, processes),
                      attempt.world.rank());
        n.give_fields(0);
        EXPECT_EQ(attempt.process.execute(0), "");
        attempt.process.give_fields(1);
        n.give_fields(1);
        attempt([&] { return execute(attempt.process, 1); });
        EXPECT_EQ(attempt.process.execute(2), "");
      });
  EXPECT_GT(failures, 10);
}

TEST(ProcessFailures, MemoryThatLacksInAnyPhaseOfTracedPaths) {
  const int failures = lack_each(
      "frames:\n  - {name: light, size: [6, 6], effects: [single_scattering, volume_shadows],\n"
      "     lights: [{directional: [1, 1, 2]}], path_tracing: {samples: 2, accumulate: true}, "
      "meshes: [\n"
      "     {mesh: m, volume: {field: p}, isosurfaces: [{field: p, values: [1], opacity: 0.5, "
      "normals: cell}]}, {mesh: n, volume: {field: p}}]}\n",
      29, [](Attempt& attempt) {
        FurtherMesh n(attempt.process, "n", attempt.whole,
                      fixtures::empty_root(attempt.whole, processes), attempt.world.rank());
        n.give_fields(0);
        EXPECT_EQ(attempt.process.execute(0), "");
        n.give_fields(1);
        attempt([&] { return execute(attempt.process, 1); });
        EXPECT_EQ(attempt.process.execute(2), "");
      });
  EXPECT_GT(failures, 5);
}

/// Steps over the cells of several processes ask for these; and once more, as another cycle.
TEST(ProcessFailures, MemoryThatLacksInAnyPhaseOfFarSteps) {
  const std::string seeds =
      "seeds: {box: {min: [0.1, 0.1, 0.1], max: [2.9, 2.9, 2.9], counts: [3, 3, 2]}}, velocity: u, "
      "integrator: {method: rk4, step: 1.2}, fields: [p, c], output: [csv]";
  const int failures = lack_each(
      "tracers:\n  - {name: paths, times: {interval: 0.1}, effects: [{boundary: {other: "
      "slide}}], " +
          seeds + "}\n  - {name: lines, kind: streamline, until: {duration: 3}, " + seeds + "}\n",
      7, [](Attempt& attempt) {
        EXPECT_EQ(attempt.process.execute(0), "");
        attempt.process.give_fields(1);
        attempt([&] { return execute(attempt.process, 1); });
        EXPECT_EQ(attempt.process.execute(2), "");
      });
  EXPECT_GT(failures, 10);
}

TEST(ProcessFailures, MemoryThatLacksInAnyPhaseOfACheckpoint) {
  const int failures = lack_each(moving, 3, [](Attempt& attempt) {
    const std::string file = attempt.folder / "state";
    EXPECT_EQ(attempt.process.execute(0), "");
    EXPECT_EQ(attempt.process.execute(1), "");
    attempt([&] {
      attempt.process.session().checkpoint(file);
      return std::string();
    });
    attempt.world.agree_after([&] { EXPECT_NE(std::filesystem::exists(file), attempt.failed); });
    attempt.process.session().checkpoint(file);
    EXPECT_EQ(attempt.process.execute(2), "");
  });
  EXPECT_GT(failures, 10);
}

/// The steps before stay, and the next one is held.
TEST(ProcessFailures, MemoryThatLacksInAnyPhaseOfHoldingAStep) {
  const int failures = lack_each(
      "hold: {steps: 3}\nframes:\n  - {name: seen, size: [8, 8], isosurfaces: [{field: c, values: "
      "[0.5]}]}\n",
      11, [](Attempt& attempt) {
        api::Session& session = attempt.process.session();
        const auto move = [&](double by) {
          std::vector<Vec3d> points = attempt.whole.vertices;
          for (Vec3d& x : points)
            x.x += by * x.y;
          attempt.process.part().move(attempt.process.mesh().mesh(), points);
        };
        EXPECT_EQ(attempt.process.execute(0), "");
        move(0.1);
        attempt.process.give_fields(1);
        attempt([&] { return execute(attempt.process, 1); });
        move(0.2);
        EXPECT_EQ(attempt.process.execute(2), "");
        const std::vector<std::int64_t> held = session.held();
        attempt.world.agree_after([&] {
          EXPECT_TRUE(held == (std::vector<std::int64_t>{0, 1, 2}) ||
                      (attempt.failed && held == (std::vector<std::int64_t>{0, 2})));
        });
        session.show(0);
        EXPECT_EQ(session.execute(10, 0.0), "");
        session.show(INSITU_LIVE);
      });
  EXPECT_GT(failures, 5);
}

namespace {

/// What comes from two cycles on other cells than the attempt's.
std::string state_of(Attempt& attempt) {
  const std::string file = attempt.folder / "state";
  PartSession::Options options;
  options.scene = "insitu: 1\npage: false\n" + moving;
  options.folder = attempt.folder / "before";
  PartSession before(attempt.world, attempt.whole, fixtures::slabs(attempt.whole, processes),
                     options);
  EXPECT_EQ(before.execute(0), "");
  EXPECT_EQ(before.execute(1), "");
  before.session().checkpoint(file);
  EXPECT_EQ(before.session().finish(), "");
  return file;
}

} // namespace

/// What is refused changes nothing: the next one works.
TEST(ProcessFailures, MemoryThatLacksInAnyPhaseOfARestart) {
  const int failures = lack_each(moving, 3, [](Attempt& attempt) {
    const std::string file = state_of(attempt);
    attempt([&] {
      attempt.process.session().restart(file);
      return std::string();
    });
    if (attempt.failed)
      attempt.process.session().restart(file);
    EXPECT_EQ(attempt.process.execute(2), "");
  });
  EXPECT_GT(failures, 10);
}

/// The first execution after a restart, in which cells and particles are dealt.
TEST(ProcessFailures, MemoryThatLacksInAnyPhaseAfterARestart) {
  const int failures = lack_each(moving, 25, [](Attempt& attempt) {
    attempt.process.session().restart(state_of(attempt));
    attempt.process.give_fields(2);
    attempt([&] { return execute(attempt.process, 2); });
    EXPECT_EQ(attempt.process.execute(3), "");
  });
  EXPECT_GT(failures, 10);
}
