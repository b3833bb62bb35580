// Flat meshes over processes: the files of one process, to the byte.
#include <cmath>
#include <map>
#include <optional>

#include "flat_part.h"
#include "part_session.h"

using namespace insitu;
using namespace insitu::test;
using flat_meshes::Flat;
using flat_meshes::Kind;

namespace {

const char* const scene = R"(insitu: 1
page: false
probes:
  - {name: probes, points: {box: {min: [0, 0, 7], max: [5, 5, 7], counts: [11, 11, 1]}}, fields: [p, u, c]}
tracers:
  - {name: paths, velocity: u, kind: pathline, seeds: {box: {min: [1, 1, 0], max: [4, 4, 0], counts: [4, 4, 1]}}, fields: [p, c], output: [csv, vtp]}
  - {name: kept, velocity: u, seeds: {box: {min: [0, 0, 3], max: [5, 5, 3], counts: [4, 4, 1]}}, effects: [{boundary: slide}], output: [csv]}
  - {name: walks, velocity: u, seeds: {box: {min: [2, 2, 0], max: [3, 3, 0], counts: [2, 2, 1]}}, effects: [{diffusion: {horizontal: 0.1, vertical: 5, seed: 3}}], output: [csv]}
  - {name: lines, velocity: u, kind: streamline, integrator: {max_steps: 60}, seeds: [[1, 3, 0], [2.2, 2.5, 9]], output: [vtp]}
frames:
  - {name: smoke, size: [24, 20], images: [color, depth, cell], volume: {field: p, opacity: [[0, 0], [1, 0.1], [5, 0.8]]}}
  - {name: surfaces, size: [24, 24], images: [color, depth, cell], isosurfaces: [{field: p, values: [1, 3], normals: smooth, color: {field: c}}], boundary: {color: {field: u, component: 0}}}
)";

constexpr int n = 5; // squares along each axis

/// moves: the vertices, at each step.
std::map<std::string, std::string> run(const Flat& whole, const std::vector<int>& process,
                                       int processes, bool moves) {
  const OwnFolder folder;
  const std::string out = folder / "out";
  run_processes(processes, [&](parallel::World& world) {
    FlatPart part(whole, process, world.rank());
    with_session(world, scene, out, [&](api::Session& session) {
      commit::CommittedMesh& mesh = session.mesh("m").mesh;
      if (!part.cells.empty())
        part.give(mesh.mesh());
      for (int cycle = 0; cycle < 2; ++cycle) {
        if (cycle > 0 && moves)
          part.move(mesh.mesh());
        if (!part.cells.empty())
          part.give_fields(mesh.mesh(), 0.37 * cycle, 0.5 * n);
        EXPECT_EQ(session.execute(cycle, 0.25 * cycle), "");
      }
    });
  });
  return files_of(out);
}

/// A run whose cells become others at a cycle; stopped before it on some processes, it goes on on
/// others. stops: not at all where the second number is 0.
std::map<std::string, std::string> run_over_cells(int first, int second) {
  const std::string tracers =
      "insitu: 1\npage: false\ntracers:\n"
      "  - {name: paths, velocity: u, seeds: {box: {min: [1, 1, 0], max: [4, 4, 0], counts: [5, 5, "
      "1]}}, fields: [p, c], output: [csv]}\n";
  const Flat triangles = flat_meshes::flat_mesh(n, Kind::triangles, true),
             quads = flat_meshes::flat_mesh(n, Kind::quads, true);
  const OwnFolder folder;
  const std::string out = folder / "out", state = folder / "state";
  const auto go = [&](int processes, int from, int to) {
    run_processes(processes, [&](parallel::World& world) {
      std::optional<FlatPart> part;
      with_session(world, tracers.c_str(), out, [&](api::Session& session) {
        mesh::Mesh& mesh = session.mesh("m").mesh.mesh();
        for (int cycle = from; cycle < to; ++cycle) {
          if (cycle == from || cycle == 2) {
            const Flat& whole = cycle < 2 ? triangles : quads;
            part.emplace(whole, flat_slabs(whole, processes), world.rank());
            part->give(mesh);
          }
          part->give_fields(mesh, 0.37 * cycle, 0.5 * n);
          if (cycle == from && from > 0)
            session.restart(state);
          EXPECT_EQ(session.execute(cycle, 0.25 * cycle), "");
        }
        if (to == 2)
          session.checkpoint(state);
      });
    });
  };
  go(first, 0, second ? 2 : 4);
  if (second)
    go(second, 2, 4);
  return files_of(out);
}

void expect_files_of_one(Kind kind, bool moves, const std::vector<int>& numbers) {
  const Flat whole = flat_meshes::flat_mesh(n, kind, true);
  const auto slabs = [&](int processes) { return flat_slabs(whole, processes); };
  const auto expected = run(whole, slabs(1), 1, moves);
  EXPECT_GE(expected.size(), 12u);
  for (const int processes : numbers)
    expect_same(expected, run(whole, slabs(processes), processes, moves),
                std::to_string(processes));
  std::vector<int> one_without; // the first process has no cells
  for (std::size_t c = 0; c < whole.cells.size(); ++c)
    one_without.push_back(1 + int(c % 2));
  expect_same(expected, run(whole, one_without, 3, moves), "by turns");
}

} // namespace

TEST(ProcessFlatMeshes, FilesAreThoseOfOneProcessToTheByte) {
  expect_files_of_one(Kind::mixed, false, {2, 4});
}

TEST(ProcessFlatMeshes, FilesAreThoseOfOneProcessWhereVerticesMove) {
  expect_files_of_one(Kind::triangles, true, {4});
}

/// Cells that are others at the first cycle after a restart, on as many processes and on others.
TEST(ProcessFlatMeshes, GoOnFromACheckpointOverAChangeOfCells) {
  const auto expected = run_over_cells(1, 0);
  ASSERT_EQ(expected.size(), 1u);
  EXPECT_GT(std::ranges::count(expected.begin()->second, '\n'), 60);
  for (const auto& [first, second] :
       {std::pair(1, 1), std::pair(1, 3), std::pair(2, 2), std::pair(3, 2), std::pair(2, 1)})
    expect_same(expected, run_over_cells(first, second),
                std::to_string(first) + " to " + std::to_string(second));
}
