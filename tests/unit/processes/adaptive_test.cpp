/// Scenes of adaptive meshes over processes: their files are those of one process, to the byte.
#include "amr_meshes.h"
#include "amr_session.h"
#include "images.h"
#include "shown_again.h"

using namespace insitu;
using namespace insitu::test;

namespace {

void expect_one(const std::string& scene, insitu_reconstruction how, std::size_t files) {
  for (const AmrMesh& whole : {octree(), patches()}) {
    const auto expected = run_amr(whole, how, 1, deal_of(0, 1), scene);
    EXPECT_GE(expected.size(), files);
    for (const auto& [processes, kind] :
         {std::pair(2, 0), std::pair(3, 2), std::pair(4, 1), std::pair(8, 3)})
      expect_same(expected, run_amr(whole, how, processes, deal_of(kind, processes), scene),
                  "deal " + std::to_string(kind) + " on " + std::to_string(processes));
  }
}

} // namespace

/// By both reconstructions; the leaves regrid between the steps that are held.
TEST(ProcessAdaptive, HeldSteps) {
  const std::string base =
      "insitu: 1\npage: false\nhold: {steps: 3}\n"
      "probes:\n"
      "  - {name: line, points: {line: {from: [-0.2, 0.3, 0.1], to: [4.1, 3.7, 3.9], count: 60}},\n"
      "     fields: [s, v], outside: nearest}\n"
      "frames:\n"
      "  - {name: inside, size: [24, 24], volume: {field: s}}\n";
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST}) {
    const std::string scene =
        base + "  - {name: seen, size: [24, 24], " +
        (how == INSITU_DUAL ? "isosurfaces: [{field: s, values: [0.3]}]" : "boundary: {}") + "}\n";
    std::map<std::string, std::string> expected;
    for (const auto& [processes, kind] : {std::pair(1, 0), std::pair(2, 0), std::pair(3, 2)}) {
      const OwnFolder folder;
      const std::string out = folder / "out";
      const Deal deal = deal_of(kind, processes);
      run_processes(processes, [&](parallel::World& world) {
        AmrSession process(world, octree(), how, deal, scene, out);
        for (int cycle = 0; cycle < 4; ++cycle) {
          if (cycle == 2)
            process.give(world, patches(), how, deal);
          EXPECT_EQ(process.execute(cycle), "");
        }
        show_again(process.session(), {1, 3, 2, 1});
        EXPECT_EQ(process.session().finish(), "");
      });
      const auto files = files_of(out);
      if (expected.empty())
        expected = files;
      expect_same(expected, files, "on " + std::to_string(processes));
      EXPECT_EQ(expect_shown_as_live(files), 6);
    }
  }
}

TEST(ProcessAdaptive, ProbesAndConditions) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "probes:\n"
      "  - {name: line, points: {line: {from: [-0.2, 0.3, 0.1], to: [4.1, 3.7, 3.9], count: 60}},\n"
      "     fields: [s, v], outside: nearest}\n"
      "  - {name: seams, points: {plane: {origin: [0, 0, 2], u: [4, 0, 0], v: [0, 4, 0], counts: "
      "[9, 9]}},\n"
      "     fields: [s], when: max(s) > 0.5 and mean(s) < 10}\n";
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
    expect_one(scene, how, 2);
}

TEST(ProcessAdaptive, Frames) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "frames:\n"
      "  - {name: smoke, size: [32, 24], images: [color, depth, cell], format: [png, exr],\n"
      "     volume: {field: s, opacity: [[-1, 0.05], [1, 0.8]]}, scalar_bar: true}\n"
      "  - {name: light, size: [20, 18], volume: {field: s, opacity: [[-1, 0.05], [1, 0.8]]},\n"
      "     effects: [multiple_scattering], path_tracing: {samples: 2}}\n"
      "  - {name: surfaces, size: [24, 24], isosurfaces: [{field: s, values: [-0.3, 0.4],\n"
      "     opacity: 0.6, color: {field: v, component: 1}}], outline: {}}\n"
      "  - {name: held, size: [24, 24], volume: {field: s, tolerance: 0.1,\n"
      "     opacity: [[-1, 0], [0, 0], [1, 0.8]]}}\n"
      "  - {name: skin, size: [70, 70], images: [cell], samples_per_pixel: 2, boundary: {}}\n";
  expect_one(scene, INSITU_DUAL, 15);
  expect_one(
      "insitu: 1\npage: false\nframes:\n"
      "  - {name: smoke, size: [32, 24], images: [color, cell],\n"
      "     volume: {field: s, opacity: [[-1, 0.05], [1, 0.8]]}}\n"
      "  - {name: light, size: [20, 18], volume: {field: s, opacity: [[-1, 0.05], [1, 0.8]]},\n"
      "     effects: [single_scattering], path_tracing: {samples: 2}}\n"
      "  - {name: skin, size: [24, 24], boundary: {color: {field: s}}}\n",
      INSITU_NEAREST, 12);
}

/// Through a transparent boundary no face inside is seen, where leaves of one depth or of several
/// touch: each ray through the block meets it twice.
TEST(ProcessAdaptive, TransparentBoundaries) {
  const std::string scene =
      "insitu: 1\npage: false\nframes:\n"
      "  - {name: f, size: [48, 40], format: [png, exr], background: transparent,\n"
      "     boundary: {opacity: 0.2}}\n"
      "  - {name: lit, size: [32, 32], effects: [shadows], boundary: {opacity: 0.2, color: {field: "
      "s}}}\n";
  const int twice = int(std::lround(255 * (1 - 0.8 * 0.8)));
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST}) {
    expect_one(scene, how, 9);
    for (const AmrMesh& whole : {octree(), patches()}) {
      const auto files = run_amr(whole, how, 1, deal_of(0, 1), scene);
      const output::PngImage image = image_of(files.at("f_000000.png"));
      ASSERT_EQ(image.channels, 4);
      int seen = 0;
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
          if (const int alpha = image.pixel(x, y)[3]; alpha != 0) {
            ++seen;
            EXPECT_EQ(alpha, twice) << how << " " << x << " " << y;
          }
      EXPECT_GT(seen, 400) << how;
    }
  }
}

/// Leaves in one frame with cubes that overlap them and are cut in another way.
TEST(ProcessAdaptive, FramesWithAnotherMesh) {
  const AmrMesh leaves = octree();
  TestMesh cubes = jittered_cubes(3);
  for (Vec3d& x : cubes.vertices)
    x += Vec3d{1.7, 0.6, 1.5};
  const std::string scene =
      "insitu: 1\npage: false\nframes:\n"
      "  - name: f\n    size: [48, 40]\n    format: [png, exr]\n    images: [color, depth]\n"
      "    effects: [shadows, volume_shadows]\n    meshes:\n"
      "      - {mesh: n, volume: {field: p, opacity: [[0, 0], [16, 0.04]]}, boundary: {opacity: "
      "0.2}}\n"
      "      - {mesh: m, volume: {field: s, opacity: [[-1, 0], [1, 0.06]], shading: true}";
  const std::string ends[] = {", isosurfaces: [{field: s, values: [0.2], opacity: 0.5}]}\n", "}\n"};
  for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST}) {
    const std::string whole_scene = scene + ends[how == INSITU_NEAREST];
    std::map<std::string, std::string> expected;
    for (const int processes : {1, 2, 3, 4}) {
      const OwnFolder folder;
      const std::string out = folder / "out";
      const fixtures::Partition partition = fixtures::boxes(cubes, processes);
      run_processes(processes, [&](parallel::World& world) {
        AmrSession process(world, leaves, how, deal_of(processes == 3 ? 2 : 1, processes),
                           whole_scene, out);
        fixtures::Part part(cubes, partition, world.rank());
        mesh::Mesh& to = process.session().mesh("n").mesh.mesh();
        part.give(to, true);
        part.give_field(to, "p", INSITU_VERTEX, 1, WholeFields(cubes, 0).p);
        EXPECT_EQ(process.execute(0), "");
        EXPECT_EQ(process.session().finish(), "");
      });
      const auto files = files_of(out);
      EXPECT_EQ(files.size(), 5u);
      if (processes == 1)
        expected = files;
      expect_same(expected, files, std::to_string(processes) + " processes");
    }
  }
}

/// Values jump from leaf to leaf; what was drawn hung on how leaves are stored.
TEST(ProcessAdaptive, NoIsosurfacesByNearest) {
  for (const int processes : {1, 2}) {
    const OwnFolder folder;
    run_processes(processes, [&](parallel::World& world) {
      AmrSession process(world, octree(), INSITU_NEAREST, deal_of(0, processes),
                         "insitu: 1\npage: false\nframes:\n"
                         "  - {name: surfaces, size: [8, 8], isosurfaces: [{field: s, values: "
                         "[0.3]}]}\n",
                         folder / "out");
      const std::string failure = process.execute(0);
      EXPECT_NE(failure.find("reconstruction is `nearest`"), std::string::npos) << failure;
    });
  }
}

TEST(ProcessAdaptive, Tracers) {
  const std::string scene =
      "insitu: 1\npage: false\n"
      "tracers:\n"
      "  - {name: paths, velocity: v, fields: [s], kind: pathline,\n"
      "     seeds: {box: {min: [0.5, 0.5, 0.5], max: [3.5, 3.5, 3.5], counts: [5, 5, 5]}},\n"
      "     output: [csv]}\n"
      "  - {name: lines, velocity: v, kind: streamline, until: {duration: 4},\n"
      "     seeds: {box: {min: [0.5, 0.5, 0.5], max: [3.5, 3.5, 3.5], counts: [3, 3, 3]}}}\n";
  expect_one(scene, INSITU_DUAL, 2);
}

/// Steps that go over the cells of several processes.
TEST(ProcessAdaptive, FarSteps) {
  const std::string far =
      "seeds: {box: {min: [0.5, 0.5, 0.5], max: [3.5, 3.5, 3.5], counts: [5, 5, 5]}}, integrator: "
      "{method: rk4, step: 0.8}";
  const std::string scene =
      "insitu: 1\npage: false\n"
      "tracers:\n"
      "  - {name: paths, velocity: v, fields: [s], kind: pathline, times: {interval: 0.07},\n"
      "     output: [csv], " +
      far +
      "}\n"
      "  - {name: walls, velocity: v, fields: [s], kind: pathline, output: [csv],\n"
      "     effects: [{boundary: {other: slide}}], " +
      far +
      "}\n"
      "  - {name: lines, velocity: v, fields: [s], kind: streamline, until: {duration: 4},\n"
      "     spacing: {length: 0.1}, " +
      far + "}\n";
  expect_one(scene, INSITU_DUAL, 3);
  expect_one(scene, INSITU_NEAREST, 2);
}

namespace {

/// Particles on grids that become others at some cycles, on some processes alone.
void expect_one_over_regrids(const std::vector<AmrMesh>& grids, insitu_reconstruction how,
                             const std::vector<std::pair<int, int>>& sizes,
                             const std::string& word) {
  const std::string seeds =
      "{box: {min: [0.3, 0.3, 0.3], max: [3.7, 3.7, 3.7], counts: [5, 5, 5]}}";
  const std::string scene =
      "insitu: 1\npage: false\ntracers:\n"
      "  - {name: paths, velocity: v, fields: [s, v], seeds: " +
      seeds +
      ", output: [csv]}\n"
      "  - {name: streaks, velocity: v, kind: streakline, times: {interval: 0.07}, fields: [s],\n"
      "     seeds: {points: [[1.5, 1.5, 1.5], [2, 2, 2], [3.1, 1, 2.4]]}, output: [csv]}\n"
      "  - {name: sliding, velocity: v, seeds: " +
      seeds +
      ", effects: [{boundary: {other: slide}}, {settling: {speed: 0.2}}, {diffusion: {coefficient: "
      "0.01}}], fields: [s], output: [csv]}\n";
  const auto run = [&](int processes, int kind) {
    const OwnFolder folder;
    const std::string out = folder / "out";
    run_processes(processes, [&](parallel::World& world) {
      AmrSession process(world, grids[0], how, deal_of(kind, processes), scene, out);
      for (int cycle = 0; cycle < 6; ++cycle) {
        // From another deal to another one, to another grid, and back after a cycle of the same.
        const std::size_t grid = cycle < 2 ? 0 : cycle < 4 ? 1 : 2;
        if (cycle == 1 || cycle == 2 || cycle == 4)
          process.give(world, grids[grid % grids.size()], how,
                       deal_of(cycle == 1 ? 3 : (kind + cycle) % 4, processes));
        EXPECT_EQ(process.execute(cycle), "");
      }
      EXPECT_EQ(process.session().finish(), "");
    });
    return files_of(out);
  };
  const auto expected = run(1, 0);
  std::string all;
  for (const auto& [name, text] : expected)
    all += name + text;
  EXPECT_NE(all.find(word), std::string::npos);
  for (const auto& [processes, kind] : sizes)
    expect_same(expected, run(processes, kind),
                "deal " + std::to_string(kind) + " on " + std::to_string(processes));
}

} // namespace

/// Particles go on to the cells of other grids, blended between both, as in one process.
TEST(ProcessAdaptive, ParticlesGoOnToOtherCells) {
  const std::vector<std::pair<int, int>> sizes{{2, 0}, {3, 2}, {4, 1}};
  expect_one_over_regrids({octree(), patches()}, INSITU_DUAL, sizes, "killed");
  expect_one_over_regrids({octree(), patches()}, INSITU_NEAREST, sizes, "killed");
}

/// The same on larger grids: cubes in gridlets, and where most cells stitch none.
TEST(ProcessAdaptive, ParticlesGoOnToOtherCellsOfLargerGrids) {
  expect_one_over_regrids({refined_block(3), refined_block(6), refined_block(8)}, INSITU_DUAL,
                          {{2, 0}}, "killed");
  expect_one_over_regrids({checkers(0), checkers(1)}, INSITU_DUAL, {{2, 0}}, "killed");
}

/// A layer of cells that no process has, between those of two, is named by the root, once: as wide
/// as the cells beside it, or twice. A wider one is a hole.
TEST(ProcessAdaptive, AMissingLayerIsNamed) {
  struct Case {
    std::int64_t first, behind; ///< the layers that are missing
    bool is_told;
    double third = 4.0; ///< from here on cells are process 1's
  };
  for (const Case& c : {Case{4, 4, false}, Case{4, 5, true}, Case{4, 6, true}, Case{4, 7, false},
                        Case{4, 5, true, 3.0}}) {
    AmrMesh whole;
    whole.lattice = {{0, 0, 0}, {1, 1, 1}};
    whole.depth_of = {0, 1};
    for (std::int64_t i = 0; i < 8; ++i)
      for (std::int64_t j = 0; j < 8; ++j)
        for (std::int64_t k = 0; k < 2; ++k)
          if (i < c.first || i >= c.behind)
            whole.add_leaf(1, {i, j, k});
    const OwnFolder folder;
    const std::string out = folder / "out";
    run_processes(3, [&](parallel::World& world) {
      const Deal parts = [&](std::size_t, const math::Vec3d& x) {
        return x.x < 2.0 ? 0 : x.x < c.third ? 2 : 1;
      };
      AmrSession process(world, whole, INSITU_DUAL, parts,
                         "insitu: 1\npage: false\nprobes:\n"
                         "  - {name: p, points: [[0.6, 0.6, 0.6]], fields: [s]}\n",
                         out);
      EXPECT_EQ(process.execute(0), "");
      std::string all;
      for (const std::string& message : process.messages())
        all += message + "\n";
      EXPECT_EQ(
          all.find("32 faces of cells are one cell or two away from another process's cells") !=
              std::string::npos,
          c.is_told && world.is_root())
          << all;
      EXPECT_EQ(all.find("faces of cells are") != std::string::npos, c.is_told && world.is_root());
      EXPECT_EQ(process.session().finish(), "");
    });
  }
}
