// A run on an adaptive mesh: probes, tracers, triggers and frames as on any other.
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>

#include "coupled.h"

namespace {

/// A unit box of patches: a coarse one of 8^3 cells, and a fine one over its middle, which moves
/// at a regrid. density = x + 2 y + 3 z + time; velocity: rotation about the box's axis.
struct Grid {
  struct Patch {
    int level;
    std::array<std::int64_t, 3> lower, cells;
    std::vector<double> density, velocity;
  };
  std::vector<Patch> patches;
  double time = 0.0;

  explicit Grid(std::int64_t at) {
    patches.push_back({0, {0, 0, 0}, {8, 8, 8}, {}, {}});
    patches.push_back({1, {at, 4, 4}, {8, 8, 8}, {}, {}});
    fill();
  }
  void fill() {
    for (Patch& p : patches) {
      p.density.clear();
      p.velocity.clear();
      const double h = 0.125 / (1 << p.level);
      for (std::int64_t c = 0; c < p.cells[0] * p.cells[1] * p.cells[2]; ++c) {
        const double x = (double(p.lower[0] + c % p.cells[0]) + 0.5) * h;
        const double y = (double(p.lower[1] + c / p.cells[0] % p.cells[1]) + 0.5) * h;
        const double z = (double(p.lower[2] + c / p.cells[0] / p.cells[1]) + 0.5) * h;
        p.density.push_back(x + 2 * y + 3 * z + time);
        for (const double v : {0.5 - y, x - 0.5, 0.0})
          p.velocity.push_back(v);
      }
    }
  }
  void give(insitu::Mesh& mesh) {
    for (std::size_t i = 0; i < patches.size(); ++i) {
      insitu::Piece piece = mesh.piece(int(i));
      piece.patch(patches[i].level, patches[i].lower, patches[i].cells);
      piece.cell_field("density", patches[i].density);
      piece.cell_field("velocity", insitu::Array(patches[i].velocity).components(3));
    }
  }
};

const char* const scene = R"(insitu: 1
probes:
  - {name: line, points: {line: {from: [0.2, 0.3, 0.4], to: [0.83, 0.71, 0.62], count: 9}}}
  - {name: hot, points: [[0.5, 0.5, 0.5]], fields: [density], when: max(density) > 5.9}
tracers:
  - name: carried
    kind: pathline
    velocity: velocity
    seeds: [[0.3, 0.5, 0.5], [0.5, 0.75, 0.4]]
    integrator: {method: rk4, step: 0.02}
    every: 1
frames:
  - name: view
    size: [96, 72]
    volume: {field: density, colors: viridis, range: [0, 6], opacity: [[0, 0], [6, 0.5]]}
    isosurfaces: [{field: density, values: [3.1], opacity: 0.7}]
    effects: [lighting]
)";

constexpr int cycles = 6, regrid = 3; ///< the fine patch moves before that cycle

/// The adaptive mesh of a session, cycle by cycle.
class GridRun {
public:
  GridRun(const std::string& output, int threads, insitu::Reconstruction reconstruction)
      : session(options_of(output, threads)), mesh_(session.mesh("grid")) {
    insitu::AmrLevels levels;
    levels.count = 2;
    levels.spacing = {0.125, 0.125, 0.125};
    levels.reconstruction = reconstruction;
    mesh_.adaptive(levels);
  }
  /// Cycles [first, last) of the solver; the first ones after a restart from a file, if it is
  /// given.
  void go(int first, int last, const std::string& restart = {}) {
    for (int cycle = first; cycle < last; ++cycle) {
      Grid& grid = cycle < regrid ? before_ : after_;
      grid.time = 0.0;
      for (int c = 0; c < cycle; ++c)
        grid.time += 0.1;
      grid.fill();
      if (!given_ || cycle == regrid)
        grid.give(mesh_);
      else
        mesh_.changed(insitu::fields);
      given_ = true;
      if (cycle == first && !restart.empty())
        session.restart(restart);
      session.execute(cycle, grid.time);
    }
  }

  insitu::Session session;

private:
  static insitu::Options options_of(const std::string& output, int threads) {
    insitu::Options options;
    options.scene_text = scene;
    options.output = output;
    options.threads = threads;
    return options;
  }

  insitu::Mesh mesh_;
  Grid before_{4}, after_{6};
  bool given_ = false;
};

runs::Files run(const std::string& output, int threads, insitu::Reconstruction reconstruction) {
  GridRun all(output, threads, reconstruction);
  all.go(0, cycles);
  all.session.close();
  return runs::files_of(output);
}

/// Where the scene's line has the point of a row.
std::array<double, 3> line_point(const runs::Table& line, std::size_t row) {
  const double s = line.number(row, "point") / 8;
  return {0.2 + 0.63 * s, 0.3 + 0.41 * s, 0.4 + 0.22 * s};
}

double density(const std::array<double, 3>& p, double time) {
  return p[0] + 2 * p[1] + 3 * p[2] + time;
}

TEST(AdaptiveRuns, ProbesTracersAndTriggersAreRight) {
  const test::Folder folder;
  const runs::Files files = run(folder.path(), 1, insitu::Reconstruction::dual);
  const runs::Table line = runs::parse_table(files.at("line.csv"));
  ASSERT_EQ(line.rows.size(), 6u * 9u);
  for (std::size_t i = 0; i < line.rows.size(); ++i) {
    const std::array<double, 3> p = line_point(line, i);
    EXPECT_NEAR(line.number(i, "density"), density(p, line.number(i, "time")), 1e-12);
    EXPECT_NEAR(line.number(i, "velocity_x"), 0.5 - p[1], 1e-13);
    // The cell is the solver's: of the fine patch where that lies.
    const double at = line.number(i, "cycle") < 3 ? 0.25 : 0.375;
    const bool fine =
        p[0] >= at && p[0] < at + 0.5 && p[1] >= 0.25 && p[1] < 0.75 && p[2] >= 0.25 && p[2] < 0.75;
    EXPECT_EQ(line.number(i, "piece"), fine ? 1 : 0) << i;
    const double h = fine ? 0.0625 : 0.125;
    const std::int64_t lower[3] = {fine ? std::int64_t(at / h + 0.5) : 0, fine ? 4 : 0,
                                   fine ? 4 : 0};
    std::int64_t ijk[3];
    const char* const names[3] = {"r", "s", "t"};
    for (int a = 0; a < 3; ++a) {
      const double cells = p[std::size_t(a)] / h;
      ijk[a] = std::int64_t(cells) - lower[a];
      EXPECT_NEAR(line.number(i, names[a]), cells - std::floor(cells), 1e-9);
    }
    EXPECT_EQ(line.number(i, "cell"), double(ijk[0] + 8 * (ijk[1] + 8 * ijk[2]))) << i;
  }
  // The largest cell value counts, not one of the dual's: coarse cells at the far corner.
  const runs::Table hot = runs::parse_table(files.at("hot.csv"));
  const double most = 6 * (1 - 0.0625);
  for (std::size_t i = 0; i < hot.rows.size(); ++i)
    EXPECT_GT(most + hot.number(i, "time"), 5.9);
  EXPECT_GT(hot.rows.size(), 0u);
  // A linear velocity is interpolated exactly, so RK4 turns at its own accuracy.
  const runs::Table carried = runs::parse_table(files.at("carried.csv"));
  ASSERT_GT(carried.rows.size(), 0u);
  for (std::size_t i = 0; i < carried.rows.size(); ++i) {
    const double t = carried.number(i, "time");
    const double from[2][2] = {{-0.2, 0.0}, {0.0, 0.25}};
    const double* const f = from[std::size_t(carried.number(i, "particle"))];
    EXPECT_NEAR(carried.number(i, "x"), 0.5 + f[0] * std::cos(t) - f[1] * std::sin(t), 1e-9);
    EXPECT_NEAR(carried.number(i, "y"), 0.5 + f[0] * std::sin(t) + f[1] * std::cos(t), 1e-9);
  }
}

TEST(AdaptiveRuns, FilesAreTheSameOnAnyThreads) {
  const test::Folder one, two;
  for (const auto reconstruction :
       {insitu::Reconstruction::dual, insitu::Reconstruction::nearest}) {
    const std::string sub = reconstruction == insitu::Reconstruction::dual ? "/dual" : "/nearest";
    const runs::Files a = run(one.path() + sub, 1, reconstruction);
    const runs::Files b = run(two.path() + sub, 2, reconstruction);
    for (const std::string& name : runs::differences(a, b))
      ADD_FAILURE() << name;
  }
}

/// Killed after a cycle or some more, and gone on with from the checkpoint: before the regrid, just
/// before it (the particles' step then begins on the mesh as it was), and after it.
TEST(AdaptiveRuns, GoOnFromACheckpointToTheByte) {
  const test::Folder folder;
  const auto reconstruction = insitu::Reconstruction::dual;
  const runs::Files whole = run(folder / "whole", 1, reconstruction);
  for (const auto& [stop, last] : {std::pair{2, 2}, {regrid, regrid}, {2, 5}, {regrid + 1, 5}}) {
    SCOPED_TRACE("stopped after " + std::to_string(stop) + ", killed after " +
                 std::to_string(last));
    const std::string name = std::to_string(stop) + std::to_string(last);
    const std::string killed = folder / (name + "killed"), state = folder / (name + "state"),
                      output = folder / (name + "rest");
    {
      GridRun begun(killed, 1, reconstruction);
      begun.go(0, stop);
      begun.session.checkpoint(state);
      begun.go(stop, last);
      std::filesystem::copy(killed, output, std::filesystem::copy_options::recursive);
    }
    GridRun rest(output, 2, reconstruction);
    rest.go(stop, cycles, state);
    rest.session.close();
    EXPECT_EQ(runs::differences(whole, runs::files_of(output)), std::vector<std::string>{});
  }
}

TEST(AdaptiveRuns, NearestKeepsTheCellsValues) {
  const test::Folder folder;
  const runs::Files files = run(folder.path(), 1, insitu::Reconstruction::nearest);
  const runs::Table line = runs::parse_table(files.at("line.csv"));
  ASSERT_EQ(line.rows.size(), 6u * 9u);
  for (std::size_t i = 0; i < line.rows.size(); ++i) {
    const std::array<double, 3> p = line_point(line, i);
    const bool fine = line.number(i, "piece") == 1;
    const double h = fine ? 0.0625 : 0.125;
    const std::array<double, 3> centre{(std::floor(p[0] / h) + 0.5) * h,
                                       (std::floor(p[1] / h) + 0.5) * h,
                                       (std::floor(p[2] / h) + 0.5) * h};
    EXPECT_NEAR(line.number(i, "density"), density(centre, line.number(i, "time")), 1e-12) << i;
  }
}

} // namespace
