// Meshes whose cells are given by faces, over processes: the files of one process, to the byte.
#include <algorithm>
#include <map>

#include "solvers.h"

using namespace insitu;
using namespace insitu::test;

namespace {

const char* const scene = R"(insitu: 1
page: false
probes:
  - {name: probes, points: {box: {min: [0, 0, -0.5], max: [3, 3, 3], counts: [4, 5, 4]}}, fields: [p, u, c], outside: nearest}
tracers:
  - {name: paths, velocity: u, kind: pathline, seeds: {box: {min: [0.5, 0.5, 0.5], max: [2.5, 2.5, 2.5], counts: [4, 4, 3]}}, fields: [p, c], output: [csv, vtp]}
  - {name: kept, velocity: u, seeds: {box: {min: [1, 1, 1], max: [2, 2, 2], counts: [3, 2, 2]}}, effects: [{boundary: slide}], output: [csv]}
  - {name: lines, velocity: u, kind: streamline, seeds: [[1, 1, 1], [1.1, 1.2, 1.7]], output: [vtp]}
frames:
  - {name: smoke, size: [40, 36], images: [color, depth, cell], volume: {field: p, opacity: [[0, 0], [1, 0.1], [5, 0.8]]}}
  - {name: lit, size: [36, 40], volume: {field: c, smooth: true, shading: true, opacity: [[-1, 0], [1, 0.5]]}}
  - {name: surfaces, size: [40, 40], images: [color, depth, cell], isosurfaces: [{field: p, values: [1, 3], opacity: 0.6, normals: smooth, color: {field: c}}, {field: c, values: [0.2], normals: smooth}], boundary: {color: {field: u, component: 0}, opacity: 0.2}}
  - {name: light, size: [20, 18], images: [color, depth, cell], volume: {field: p, opacity: [[0, 0], [1, 0.3], [5, 0.8]]}, lights: [{directional: [1, 1, 2]}, {dome: true}], effects: [multiple_scattering], path_tracing: {samples: 2, accumulate: true, anisotropy: 0.4}}
  - {name: walls, size: [14, 16], volume: {field: c, smooth: true, opacity: [[-1, 0], [1, 0.5]]}, isosurfaces: [{field: p, values: [1], opacity: 0.7}], boundary: {opacity: 0.2}, lights: [{point: [1.5, 0.4, 1.6]}, {dome: true, intensity: 0.5}], effects: [single_scattering, volume_shadows], every: 2, path_tracing: {samples: 2}}
)";

using Files = std::map<std::string, std::string>;

/// moves: the vertices, at each step.
Files run(const FaceMesh& whole, const FaceDeal& deal, bool moves) {
  const OwnFolder folder;
  const std::string out = folder / "out";
  run_processes(deal.processes, [&](parallel::World& world) {
    SolverSession process(world, scene, out);
    process.take(std::make_unique<FaceSolver>(whole, deal, world.rank(), moves));
    for (int cycle = 0; cycle < 3; ++cycle)
      EXPECT_EQ(process.execute(cycle), "");
    EXPECT_EQ(process.session().finish(), "");
  });
  return files_of(out);
}

void expect_files_of_one(const FaceMesh& whole, bool moves, const std::vector<FaceDeal>& deals) {
  const Files expected = run(whole, {1}, moves);
  EXPECT_GE(expected.size(), 24u);
  for (const FaceDeal& deal : deals)
    expect_same(expected, run(whole, deal, moves), deal.name());
}

const char* const tracers = R"(insitu: 1
page: false
probes:
  - {name: marks, attached: body, points: [[1, 1, 1], [2.1, 1.3, 0.7], [9, 9, 9]], fields: [u], output: [csv]}
tracers:
  - {name: paths, velocity: u, seeds: {box: {min: [0.5, 0.5, 0.5], max: [2.5, 2.5, 2.5], counts: [5, 4, 3]}}, fields: [p, c], output: [csv, vtp]}
  - {name: curved, velocity: u, time_interpolation: cubic, seeds: [[1.3, 1.2, 1.1], [0.3, 0.4, 2]]}
  - {name: streaks, velocity: u, kind: streakline, seeds: {points: [[1, 1, 1], [1.1, 1.2, 0.7]]}, until: {duration: 0.6}, times: {interval: 0.11}, fields: [p], output: [csv]}
  - {name: walkers, velocity: u, seeds: {box: {min: [1, 1, 1], max: [2, 2, 2], counts: [3, 2, 2]}}, effects: [{boundary: reflect}, {diffusion: {coefficient: 0.02}}], output: [csv]}
  - {name: sliding, velocity: u, seeds: {box: {min: [1, 1, 1], max: [2, 2, 2], counts: [3, 2, 2]}}, effects: [{boundary: {other: slide}}, {settling: {speed: 0.3}}], output: [csv]}
)";

/// A run that stops before a cycle, on some processes, and goes on on others; 0: it does not stop.
/// Its cells are others from the cycle `change` on.
struct Run {
  const std::vector<FaceMesh>& meshes;
  bool moves;
  int cycles = 6, change = 3;

  Files files(const FaceDeal& first, const FaceDeal& second = {}, int stop = 0) const {
    const OwnFolder folder;
    const std::string out = folder / "out", state = folder / "state";
    go(first, 0, stop ? stop : cycles, out, state);
    if (stop)
      go(second, stop, cycles, out, state);
    return files_of(out);
  }

private:
  void go(const FaceDeal& deal, int from, int to, const std::string& out,
          const std::string& state) const {
    run_processes(deal.processes, [&](parallel::World& world) {
      SolverSession process(world, tracers, out);
      for (int cycle = from; cycle < to; ++cycle) {
        if (cycle == from || cycle == change) {
          const FaceMesh& mesh = cycle < change ? meshes.front() : meshes.back();
          process.take(std::make_unique<FaceSolver>(mesh, deal, world.rank(), moves));
        }
        if (cycle == from && from > 0)
          process.session().restart(state);
        EXPECT_EQ(process.execute(cycle), "");
      }
      if (to < cycles)
        process.session().checkpoint(state);
      EXPECT_EQ(process.session().finish(), "");
    });
  }
};

const FaceDeal turns{4, FaceDeal::turns}, ghosts{3, FaceDeal::slabs, true},
    rootless{3, FaceDeal::empty_root};

/// Stops before the cells become others, and at that cycle.
void expect_whole(const std::vector<FaceMesh>& meshes, bool moves,
                  const std::vector<std::pair<FaceDeal, FaceDeal>>& pairs) {
  const Run run{meshes, moves};
  const Files expected = run.files({1});
  std::string all;
  for (const auto& [name, text] : expected)
    all += text;
  EXPECT_GT(std::ranges::count(all, '\n'), 400);
  expect_same(expected, run.files(pairs.back().first), pairs.back().first.name());
  for (const auto& [first, second] : pairs)
    for (const int stop : {2, 3})
      expect_same(expected, run.files(first, second, stop),
                  first.name() + ", then " + second.name() + " before " + std::to_string(stop));
}

} // namespace

TEST(ProcessPolyhedra, FilesAreThoseOfOneProcessToTheByte) {
  expect_files_of_one(fixtures::cut_hexahedra(3, 3), false, {{2}, turns, ghosts});
}

TEST(ProcessPolyhedra, FilesAreThoseOfOneProcessWhereVerticesMove) {
  expect_files_of_one(fixtures::octahedra(2, 0.1), true, {rootless, {4, FaceDeal::turns, true}});
}

/// On as many processes and on others, polyhedra become other ones, and hexahedra.
TEST(ProcessPolyhedra, GoOnFromACheckpointAndOverAChangeOfCells) {
  expect_whole({fixtures::cut_hexahedra(3, 3), fixtures::cut_hexahedra(3, 2, 8)}, false,
               {{{1}, {1}}, {{1}, turns}, {{2}, {2}}, {turns, ghosts}});
  expect_whole({fixtures::octahedra(2, 0.1),
                fixtures::faces_of(make_mesh({.kind = MeshKind::hexahedra, .size = 3}, 4))},
               true, {{{4}, {1}}, {ghosts, rootless}});
}
