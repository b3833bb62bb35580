/// Adaptive meshes of two dimensions over processes: their files are those of one process, to the
/// byte.
#include "amr_meshes.h"
#include "amr_session.h"

using namespace insitu;
using namespace insitu::test;

namespace {

void expect_one(const std::string& scene, insitu_reconstruction how, std::size_t files) {
  for (const AmrMesh& whole : {quadtree(false), quadtree(true), flat_patches()}) {
    const auto expected = run_amr(whole, how, 1, deal_of(0, 1), scene);
    EXPECT_GE(expected.size(), files);
    for (const auto& [processes, kind] :
         {std::pair(2, 0), std::pair(3, 2), std::pair(4, 1), std::pair(4, 3)})
      expect_same(expected, run_amr(whole, how, processes, deal_of(kind, processes), scene),
                  "deal " + std::to_string(kind) + " on " + std::to_string(processes));
  }
}

} // namespace

TEST(ProcessFlatAdaptive, ProbesAndConditions) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "probes:\n"
      "  - {name: line, points: {line: {from: [-0.2, 0.3, 0.1], to: [4.1, 3.7, 3.9], count: 60}},\n"
      "     fields: [s, v], outside: nearest}\n"
      "  - {name: seams, points: {plane: {origin: [0, 0, 2], u: [4, 0, 0], v: [0, 4, 0], counts: "
      "[17, 17]}},\n"
      "     fields: [s], when: max(s) > 0.5 and mean(s) < 10}\n";
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
    expect_one(scene, how, 2);
}

TEST(ProcessFlatAdaptive, Frames) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "frames:\n"
      "  - {name: smoke, size: [32, 24], images: [color, depth, cell], format: [png, exr],\n"
      "     volume: {field: s, opacity: [[-1, 0.05], [1, 0.8]]}, scalar_bar: true}\n"
      "  - {name: skin, size: [40, 40], images: [color, cell], boundary: {color: {field: s}}}\n";
  expect_one(scene, INSITU_NEAREST, 12);
  expect_one(scene + "  - {name: surfaces, size: [24, 24], isosurfaces: [{field: s, values: [-0.3, "
                     "0.4], color: {field: v, component: 1}}]}\n",
             INSITU_DUAL, 15);
}

TEST(ProcessFlatAdaptive, Tracers) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "tracers:\n"
      "  - {name: paths, velocity: v, fields: [s], kind: pathline, output: [csv],\n"
      "     seeds: {box: {min: [0.5, 0.5, 0], max: [3.5, 3.5, 0], counts: [7, 7, 1]}}}\n"
      "  - {name: kept, velocity: v, effects: [{boundary: slide}], output: [csv],\n"
      "     seeds: {box: {min: [0.5, 0.5, 0], max: [3.5, 3.5, 0], counts: [4, 4, 1]}}}\n"
      "  - {name: lines, velocity: v, kind: streamline, until: {duration: 4},\n"
      "     seeds: {box: {min: [0.5, 0.5, 9], max: [3.5, 3.5, 9], counts: [3, 3, 1]}}}\n";
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
    expect_one(scene, how, 3);
}

/// Over regrids.
TEST(ProcessFlatAdaptive, ParticlesGoOnToOtherCells) {
  const std::string scene =
      "insitu: 1\npage: false\ntracers:\n"
      "  - {name: paths, velocity: v, fields: [s, v], integrator: {max_step: 0.04}, output: "
      "[csv],\n"
      "     seeds: {box: {min: [0.3, 0.3, 0], max: [3.7, 3.7, 0], counts: [6, 6, 1]}}}\n";
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST}) {
    const auto run = [&](int processes, int kind) {
      const OwnFolder folder;
      const std::string out = folder / "out";
      run_processes(processes, [&](parallel::World& world) {
        AmrSession process(world, quadtree(false), how, deal_of(kind, processes), scene, out);
        for (int cycle = 0; cycle < 5; ++cycle) {
          if (cycle == 2)
            process.give(world, flat_patches(), how, deal_of((kind + 1) % 4, processes));
          EXPECT_EQ(process.execute(cycle), "");
        }
        EXPECT_EQ(process.session().finish(), "");
      });
      auto files = files_of(out);
      std::erase_if(files, [](const auto& f) { return f.first.find("csv") == std::string::npos; });
      return files;
    };
    const auto expected = run(1, 0);
    ASSERT_EQ(expected.size(), 1u);
    for (const auto& [processes, kind] : {std::pair(2, 0), std::pair(3, 2), std::pair(4, 1)})
      expect_same(expected, run(processes, kind), "on " + std::to_string(processes));
  }
}

/// The last process never makes the mesh; of which kind it is, it is told.
TEST(ProcessFlatAdaptive, AProcessWithoutTheMesh) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "probes: [{name: line, points: {line: {from: [-0.2, 0.3, 7], to: [4.1, 3.7, 9], count: "
      "60}},\n"
      "          fields: [s, v]}]\n"
      "tracers: [{name: paths, velocity: v, seeds: {box: {min: [0.5, 0.5, 0], max: [3.5, 3.5, 0],\n"
      "           counts: [4, 4, 1]}}, output: [csv]}]\n"
      "frames: [{name: skin, size: [24, 24], boundary: {color: {field: s}}}]\n";
  AmrMesh octree;
  octree.lattice = {{0, 0, 0}, {1, 1, 1}};
  octree.depth_of = {0, 1};
  for (std::int64_t c = 0; c < 64; ++c)
    for (std::int64_t o = 0; o < (c == 21 ? 8 : 1); ++o) {
      const Index at = {c % 4, c / 4 % 4, c / 16};
      if (c == 21)
        octree.add_leaf(1, {2 * at[0] + (o & 1), 2 * at[1] + (o >> 1 & 1), 2 * at[2] + (o >> 2)});
      else
        octree.add_leaf(0, at);
    }
  for (const AmrMesh& whole : {quadtree(false), octree})
    for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
      expect_same(run_amr(whole, how, 1, deal_of(0, 1), scene),
                  run_amr(whole, how, 3, deal_of(0, 2), scene, 2), "on 3");
}

/// A mesh that has two dimensions on one process alone.
TEST(ProcessFlatAdaptive, OtherDimensionsAreNamed) {
  run_processes(2, [&](parallel::World& world) {
    AmrMesh mine = quadtree(false);
    mine.lattice.is_flat = world.rank() == 0;
    const OwnFolder folder;
    AmrSession process(world, mine, INSITU_DUAL, deal_of(0, 2),
                       "insitu: 1\npage: false\nprobes: [{name: p, points: [[1, 1, 0]]}]\n",
                       folder / "out");
    const std::string what = failure_of([&] { process.session().execute(0, 0.0); });
    EXPECT_NE(what.find("one mesh has one lattice"), std::string::npos) << what;
    EXPECT_NE(what.find("2 dimensions"), std::string::npos) << what;
  });
}
