// A solver that makes its mesh anew while particles are on their way.
#include <array>
#include <filesystem>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>
#include <memory>
#include <vector>

#include "coupled.h"
#include "flowing_cube.h"

namespace {

using namespace runs;

const char* const scene = R"(insitu: 1
page: false
tracers:
  - name: paths
    velocity: velocity
    fields: [density]
    seeds: {box: {min: [0.35, 0.35, 0.35], max: [0.65, 0.65, 0.65], counts: [2, 2, 2]}}
    integrator: {tolerance: 1e-11}
    every: 1
  - name: blown
    velocity: velocity
    seeds: [[0.5, 0.5, 0.5]]
    effects: [{windage: {field: wind, factor: 0.1}}]
    integrator: {tolerance: 1e-11}
    every: 1
  - name: dense
    velocity: velocity
    fields: [density]
    seeds: [[0.4, 0.5, 0.5]]
    times: {interval: 0.03}
    integrator: {tolerance: 1e-11}
  - name: streaks
    kind: streakline
    velocity: velocity
    seeds: [[0.5, 0.4, 0.5], [3, 3, 3]]
    every: 2
)";

constexpr double dt = 0.1;

/// The solver's cube at a cycle: other cells at every second.
std::unique_ptr<Cube> cube_at(int cycle) {
  const int remesh = (cycle + 1) / 2;
  return std::make_unique<Cube>(3 + remesh % 4, remesh % 2 == 1, 0.2);
}

struct Remeshing {
  explicit Remeshing(const std::string& output, int threads = 1, const char* text = scene) {
    insitu::Options options;
    options.scene_text = text;
    options.output = output;
    options.threads = threads;
    session = insitu::Session(options);
    mesh = session.mesh("cube");
  }
  /// From one cycle (not executed anew unless it is the first) to another.
  void run(int from, int to) {
    if (!cube) {
      cube = cube_at(from);
      cube->give(mesh, from * dt);
      if (from == 0) {
        EXPECT_TRUE(session.execute(0, 0.0));
      }
    }
    for (int cycle = from + 1; cycle <= to; ++cycle) {
      if (cycle % 2 == 1) {
        cube = cube_at(cycle); // what was there is gone
        cube->give(mesh, cycle * dt);
      } else {
        cube->fill(cycle * dt);
        cube->give_fields(mesh);
      }
      EXPECT_TRUE(session.execute(cycle, cycle * dt)) << insitu_last_message();
      const insitu::Report r = session.report();
      std::int64_t sum = 0;
      for (const std::int64_t n : r.particles)
        sum += n;
      EXPECT_EQ(sum, r.particles_seeded);
    }
  }
  std::unique_ptr<Cube> cube;
  insitu::Session session;
  insitu::Mesh mesh;
};

TEST(Remeshing, TracksAreThoseOfTheFlow) {
  const test::Folder folder;
  Remeshing run(folder.path());
  run.run(0, 8);
  EXPECT_EQ(run.session.report().particles[INSITU_END_LEFT], 0);
  run.session.close();
  const runs::Table paths = runs::parse_table(test::content(folder / "paths.csv"));
  ASSERT_GT(paths.rows.size(), 8u * 9u - 1u);
  for (std::size_t i = 0; i < paths.rows.size(); ++i) {
    const int particle = int(paths.number(i, "particle"));
    const double t = paths.number(i, "time");
    const Point x = carried(
        {particle & 1 ? 0.65 : 0.35, particle & 2 ? 0.65 : 0.35, particle & 4 ? 0.65 : 0.35}, 0.0,
        t, 0.0);
    EXPECT_NEAR(paths.number(i, "x"), x[0], 1e-9) << i;
    EXPECT_NEAR(paths.number(i, "y"), x[1], 1e-9) << i;
    EXPECT_NEAR(paths.number(i, "z"), x[2], 1e-9) << i;
    if (paths.text(i, "ending") == "alive") {
      EXPECT_NEAR(paths.number(i, "density"), density(x, t), 1e-8) << i;
    }
  }
  const runs::Table blown = runs::parse_table(test::content(folder / "blown.csv"));
  for (std::size_t i = 0; i < blown.rows.size(); ++i) {
    const Point x = carried({0.5, 0.5, 0.5}, 0.0, blown.number(i, "time"), 0.1);
    EXPECT_NEAR(blown.number(i, "x"), x[0], 1e-9) << i;
    EXPECT_NEAR(blown.number(i, "z"), x[2], 1e-9) << i;
  }
  // Fields at times between two steps as well; the dense output is of order 4.
  const runs::Table dense = runs::parse_table(test::content(folder / "dense.csv"));
  ASSERT_GT(dense.rows.size(), 25u);
  for (std::size_t i = 0; i < dense.rows.size(); ++i) {
    const double t = dense.number(i, "time");
    const Point x = carried({0.4, 0.5, 0.5}, 0.0, t, 0.0);
    EXPECT_NEAR(dense.number(i, "x"), x[0], 1e-7) << i;
    if (dense.text(i, "ending") == "alive") {
      EXPECT_NEAR(dense.number(i, "density"), density(x, t), 1e-6) << i;
    }
  }
}

TEST(Remeshing, FilesAreTheSameOnAnyThreads) {
  const test::Folder one, two;
  for (const auto& [folder, threads] : {std::pair(&one, 1), {&two, 2}}) {
    Remeshing run(folder->path(), threads);
    run.run(0, 6);
    run.session.close();
  }
  EXPECT_EQ(runs::differences(runs::files_of(one.path()), runs::files_of(two.path())),
            std::vector<std::string>{});
}

// The checkpoint holds the cells too: the solver's may be others when the run goes on.
TEST(Remeshing, TracksGoOnFromACheckpointToTheByte) {
  const test::Folder whole_folder;
  {
    Remeshing run(whole_folder.path());
    run.run(0, 8);
    run.session.close();
  }
  const runs::Files whole = runs::files_of(whole_folder.path());
  for (const int stop : {3, 4}) { // the next step is on the same cells, or on others
    const test::Folder folder, state;
    {
      Remeshing run(folder.path());
      run.run(0, stop);
      run.session.checkpoint(state / "s");
    }
    Remeshing run(folder.path(), 2);
    run.cube = cube_at(stop);
    run.cube->give(run.mesh, stop * dt);
    run.session.restart(state / "s");
    run.run(stop, 8);
    run.session.close();
    EXPECT_EQ(runs::differences(whole, runs::files_of(folder.path())), std::vector<std::string>{})
        << stop;
  }
}

TEST(Remeshing, TheEarlierStepIsInTheReportAndInThePlan) {
  const test::Folder folder;
  const char* const attached = "insitu: 1\npage: false\ntracers:\n  - {name: a, attached: body, "
                               "seeds: [[0.5, 0.5, 0.5]]}\n";
  const auto bytes = [](Remeshing& run, insitu_purpose purpose) {
    return run.session.report().bytes_by_purpose[purpose];
  };
  Remeshing none(folder.path(), 1, attached);
  none.run(0, 3);
  EXPECT_EQ(bytes(none, INSITU_MEMORY_EARLIER), 0);
  EXPECT_EQ(none.session.plan().find("copy of the cells"), std::string::npos);

  Remeshing run(folder.path());
  run.run(0, 4);
  const auto vertices = std::int64_t(run.cube->points.size() / 3);
  const std::int64_t kept = bytes(run, INSITU_MEMORY_EARLIER),
                     tree = bytes(run, INSITU_MEMORY_TREE);
  EXPECT_EQ(kept, vertices * 8 * (3 + 3 + 3 + 1) + std::int64_t(run.cube->ids.size()) * 4);
  EXPECT_NE(run.session.plan().find("copy of the cells"), std::string::npos);
  // Other cells are there: those before, with their tree, wait for the particles.
  run.cube = cube_at(5);
  run.cube->give(run.mesh, 5 * dt);
  run.mesh.commit();
  EXPECT_EQ(bytes(run, INSITU_MEMORY_EARLIER), kept);
  EXPECT_GT(bytes(run, INSITU_MEMORY_TREE), tree);
  EXPECT_TRUE(run.session.execute(5, 5 * dt));
  const auto now = std::int64_t(run.cube->points.size() / 3);
  EXPECT_EQ(bytes(run, INSITU_MEMORY_EARLIER),
            now * 8 * (3 + 3 + 3 + 1) + std::int64_t(run.cube->ids.size()) * 4);
}

/// Patches of cells with the flow at their centres: a coarse one, and a fine one that moves. As
/// leaves of octrees, or without what the fine one covers.
struct Patches {
  std::vector<double> velocity[2];
  std::vector<std::int32_t> levels, corners;

  using At = Point (*)(const Point&, double);
  static Point place(const std::array<std::int64_t, 3>& lower, int cell, double h) {
    return {(double(lower[0] + cell % 8) + 0.5) * h, (double(lower[1] + cell / 8 % 8) + 0.5) * h,
            (double(lower[2] + cell / 64) + 0.5) * h};
  }
  void give(insitu::Mesh& mesh, std::int64_t at, double time, At flow_at = flow) {
    const std::array<std::int64_t, 3> lower[2] = {{0, 0, 0}, {at, 4, 4}};
    for (std::size_t p = 0; p < 2; ++p) {
      velocity[p].clear();
      for (int c = 0; c < 512; ++c)
        for (const double u : flow_at(place(lower[p], c, 0.125 / double(1 << p)), time))
          velocity[p].push_back(u);
      insitu::Piece piece = mesh.piece(int(p));
      piece.patch(int(p), lower[p], {8, 8, 8});
      piece.cell_field("velocity", insitu::Array(velocity[p]).components(3));
    }
  }
  /// The same cells, those that are not covered, as leaves in one piece.
  void give_leaves(insitu::Mesh& mesh, std::int64_t at, double time, At flow_at) {
    const std::array<std::int64_t, 3> lower[2] = {{0, 0, 0}, {at, 4, 4}};
    for (const int p : {1, 0})
      for (int c = 0; c < 512; ++c) {
        const std::int64_t i[3] = {lower[p][0] + c % 8, lower[p][1] + c / 8 % 8,
                                   lower[p][2] + c / 64};
        bool covered = p == 0;
        for (std::size_t a = 0; a < 3; ++a)
          covered = covered && 2 * i[a] >= lower[1][a] && 2 * i[a] < lower[1][a] + 8;
        if (covered)
          continue;
        levels.push_back(p);
        for (const std::int64_t index : i)
          corners.push_back(std::int32_t(index));
        for (const double u : flow_at(place(lower[p], c, 0.125 / double(1 << p)), time))
          velocity[0].push_back(u);
      }
    insitu::Piece piece = mesh.piece(0);
    piece.leaves(insitu::Array(levels), insitu::Array(corners).components(3));
    piece.cell_field("velocity", insitu::Array(velocity[0]).components(3));
  }
  /// What is freed is no more.
  ~Patches() {
    std::fill(levels.begin(), levels.end(), 0x7fffffff);
    std::fill(corners.begin(), corners.end(), 0x7fffffff);
  }
};

/// The same everywhere, linear in time: exact in cells as they are.
Point even_flow(const Point&, double t) {
  return {0.1 + 0.2 * t, 0.1 - 0.25 * t, 0.15 * t};
}

constexpr const char* regrid_scene = R"(insitu: 1
page: false
tracers:
  - name: paths
    velocity: velocity
    seeds: {box: {min: [0.35, 0.35, 0.35], max: [0.65, 0.65, 0.65], counts: [2, 2, 2]}}
    integrator: {tolerance: 1e-11}
    every: 1
)";

TEST(Remeshing, ParticlesCrossRegridsOfAnAdaptiveMesh) {
  struct Case {
    insitu::Reconstruction reconstruction;
    bool leaves;
  };
  for (const Case& c : {Case{insitu::Reconstruction::dual, false},
                        {insitu::Reconstruction::nearest, false},
                        {insitu::Reconstruction::nearest, true}}) {
    const bool dual = c.reconstruction == insitu::Reconstruction::dual;
    const test::Folder folder;
    Remeshing run(folder.path(), 1, regrid_scene);
    insitu::AmrLevels levels;
    levels.count = 2;
    levels.spacing = {0.125, 0.125, 0.125};
    levels.reconstruction = c.reconstruction;
    run.mesh.adaptive(levels);
    const auto bytes = [&](insitu_purpose purpose) {
      return run.session.report().bytes_by_purpose[purpose];
    };
    std::int64_t amr = 0, earlier = 0;
    std::unique_ptr<Patches> patches;
    for (int cycle = 0; cycle <= 8; ++cycle) {
      patches = std::make_unique<Patches>(); // what was there is gone
      const std::int64_t at = 2 * (1 + cycle % 3);
      if (c.leaves)
        patches->give_leaves(run.mesh, at, cycle * dt, even_flow);
      else
        patches->give(run.mesh, at, cycle * dt, dual ? flow : even_flow);
      run.mesh.commit();
      if (cycle > 0) {
        EXPECT_GT(bytes(INSITU_MEMORY_AMR), amr * 3 / 2) << "both until particles have crossed";
        const std::int64_t cells = c.leaves ? 960 : 1024;
        EXPECT_EQ(bytes(INSITU_MEMORY_EARLIER) - earlier, dual ? 0 : 13 * cells + cells / 8);
      }
      EXPECT_TRUE(run.session.execute(cycle, cycle * dt)) << insitu_last_message();
      amr = bytes(INSITU_MEMORY_AMR);
      earlier = bytes(INSITU_MEMORY_EARLIER);
    }
    EXPECT_EQ(run.session.report().particles[INSITU_END_ALIVE], 8);
    run.session.close();
    const runs::Table paths = runs::parse_table(test::content(folder / "paths.csv"));
    for (std::size_t i = 0; i < paths.rows.size(); ++i) {
      const int particle = int(paths.number(i, "particle"));
      const double t = paths.number(i, "time");
      Point x{particle & 1 ? 0.65 : 0.35, particle & 2 ? 0.65 : 0.35, particle & 4 ? 0.65 : 0.35};
      if (dual)
        x = carried(x, 0.0, t, 0.0);
      else
        x = {x[0] + 0.1 * t + 0.1 * t * t, x[1] + 0.1 * t - 0.125 * t * t, x[2] + 0.075 * t * t};
      EXPECT_NEAR(paths.number(i, "x"), x[0], 1e-9) << i;
      EXPECT_NEAR(paths.number(i, "y"), x[1], 1e-9) << i;
      EXPECT_NEAR(paths.number(i, "z"), x[2], 1e-9) << i;
    }
  }
}

} // namespace
