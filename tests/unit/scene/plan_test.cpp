// What a plan says is what is made: bytes and counts of a run's structures against its plan.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "../query/registered_amr.h"
#include "../render/render_mesh.h"
#include "core/context.h"
#include "scene/parse/parse.h"
#include "scene/run/runner.h"
#include "scene_test.h"

namespace insitu::test {
namespace {

struct Cells {
  int n = 7;
  Shape shape = Shape::hexahedron;
  double jitter = 0.2;
};

struct PlannedRun {
  explicit PlannedRun(const std::string& items, Cells of = {})
      : mesh(of.n, of.shape, of.jitter), folder(std::filesystem::temp_directory_path() /
                                                ("insitu-plan-" + std::to_string(::getpid()))),
        context(0, mesh.committed.log),
        runner(scene::parse_scene_text("insitu: 1\n" + items, "s.yaml"), folder.string(), context,
               world, statistics) {
    mesh.field("p", INSITU_VERTEX, [](const Vec3d& p) { return p.x + p.y * p.z; });
    mesh.field("c", INSITU_CELL, [](const Vec3d& p) { return p.x - p.y; });
  }
  ~PlannedRun() { std::filesystem::remove_all(folder); }

  scene::Plan plan() { return runner.plan(meshes); }
  std::string execute(std::int64_t cycle) { return runner.execute(meshes, cycle, double(cycle)); }

  RenderMesh mesh;
  std::filesystem::path folder;
  core::Context context;
  parallel::SerialWorld world;
  scene::Statistics statistics;
  scene::Runner runner;
  commit::CommittedMesh* list[1] = {&mesh.committed.mesh};
  scene::MeshList meshes{list};
};

const char* const scenes[] = {
    "frames: [{name: f, size: [8, 8], volume: {field: p}}]",
    "frames: [{name: f, size: [8, 8], volume: {field: p, range: [0, 1]}}]",
    "frames: [{name: f, size: [8, 8], volume: {field: c, smooth: true}}]",
    "frames: [{name: f, size: [8, 8], isosurfaces: [{field: p, values: [0.5]}]}]",
    "frames: [{name: f, size: [8, 8], isosurfaces: [{field: c, values: [0.1, 0.2]}]}]",
    "frames: [{name: f, size: [8, 8], effects: [lighting, shadows], isosurfaces: [{field: p, "
    "values: [0.4], normals: smooth}]}]",
    "frames: [{name: f, size: [8, 8], volume: {field: c, smooth: true}, isosurfaces: [{field: c, "
    "values: [0.1]}, {field: p, values: [0.2], color: {field: c}}]}, {name: g, size: [4, 4], "
    "isosurfaces: [{field: p, values: [0.7]}]}]",
};

TEST(Plan, TellsTheBytesThatAreHeld) {
  for (const char* items : scenes) {
    SCOPED_TRACE(items);
    PlannedRun run(items);
    core::Memory& memory = run.context.memory;
    const scene::Plan plan = run.plan();
    EXPECT_EQ(memory.current(), 0) << "a plan makes nothing";
    // What is made only if it pays does not for so few rays.
    std::int64_t kept = plan.kept_bytes();
    for (const scene::Plan::Entry& e : plan.entries())
      if (e.needed && !e.shared && e.at_most && e.held == scene::Plan::Held::kept)
        kept -= e.bytes;
    for (std::int64_t cycle = 0; cycle < 2; ++cycle) {
      memory.reset_peak();
      EXPECT_EQ(run.execute(cycle), "");
      EXPECT_EQ(memory.current(), kept) << plan.text();
      EXPECT_LE(memory.peak(), plan.bytes()) << plan.text();
      EXPECT_GE(memory.peak(), kept + 8 * 8 * 16) << "an image of 8 x 8 at least";
    }
  }
}

/// Bytes of entries of which these are the item's first words.
std::int64_t bytes_of(const scene::Plan& plan, const std::string& item) {
  std::int64_t sum = 0;
  for (const scene::Plan::Entry& e : plan.entries())
    if (e.needed && !e.shared && e.item.rfind(item, 0) == 0)
      sum += e.bytes;
  return sum;
}

/// A run whose plan's items hold what is said, to the byte.
void expect_held(PlannedRun& run, std::int64_t at_least, const std::string& what) {
  const scene::Plan plan = run.plan();
  EXPECT_EQ(run.execute(0), "");
  EXPECT_EQ(run.context.memory.current(), plan.kept_bytes()) << what << "\n" << plan.text();
  EXPECT_LE(run.context.memory.peak(), plan.bytes()) << what << "\n" << plan.text();
  EXPECT_GE(run.context.memory.current(), at_least) << what;
}

TEST(Plan, TellsTheBytesOfPathTracingAndTolerances) {
  PlannedRun paths("frames: [{name: f, size: [16, 12], effects: [single_scattering], "
                   "path_tracing: {samples: 1, accumulate: true}, "
                   "volume: {field: p, range: [0, 1]}}]");
  expect_held(paths, 16 * 12 * 16, "sums of samples");
  EXPECT_EQ(bytes_of(paths.plan(), "macrocell grid"),
            17 * (bytes_of(paths.plan(), "majorants") / 4));
  PlannedRun bound("frames: [{name: f, size: [16, 12], volume: {field: p, range: [0, 1], "
                   "opacity: [[0, 1], [1, 1]], nan_opacity: 1, tolerance: 0.1}}]");
  expect_held(bound, 21, "a grid with sizes");
}

/// Images are counted while they are there, also those that nobody asked for by name, and their
/// files.
TEST(Plan, ImagesAndTheirFilesAreCounted) {
  std::int64_t before = 0;
  for (const char* images : {"", ", images: [color, depth]", ", images: [color, depth, cell]",
                             ", images: [color, depth, cell], format: [png, exr]",
                             ", images: [color, depth, cell], samples_per_pixel: 3"}) {
    SCOPED_TRACE(images);
    PlannedRun run("frames: [{name: f, size: [64, 48], isosurfaces: [{field: p, values: [0.5]}]" +
                   std::string(images) + "}]");
    const scene::Plan plan = run.plan();
    EXPECT_EQ(run.execute(0), "");
    const std::int64_t peak = run.context.memory.peak();
    EXPECT_LE(peak, plan.bytes()) << plan.text();
    EXPECT_GE(peak, plan.kept_bytes() + bytes_of(plan, "image of")) << plan.text();
    EXPECT_GE(peak, before);
    before = peak;
  }
  EXPECT_GT(before, 64 * 48 * (16 + 16 + 4 + 8));
}

std::string tetrahedron_stl() {
  const char* corners[] = {"0 0 0", "1 0 0", "0 1 0", "0 0 1"};
  std::string text = "solid t\n";
  for (int left = 0; left < 4; ++left) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 4; ++k)
      if (k != left)
        text += std::string("vertex ") + corners[k] + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid t\n";
}

/// What Embree holds is not known before: to a third, and for few triangles a few kilobytes.
TEST(Plan, TellsAboutTheBytesOfTriangles) {
  for (const Shape shape : {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid}) {
    SCOPED_TRACE(testing::Message() << "shape " << int(shape));
    PlannedRun run("frames: [{name: f, size: [8, 8], boundary: {opacity: 0.5}, outline: {ticks: "
                   "true}}]",
                   {16, shape, 0.2});
    const scene::Plan plan = run.plan();
    EXPECT_EQ(run.execute(0), "");
    const auto held = double(run.context.memory.current());
    EXPECT_NEAR(held, double(plan.kept_bytes()), 0.33 * held + 4096) << plan.text();
    EXPECT_LE(double(run.context.memory.peak()), 1.33 * double(plan.bytes()) + 4096);
    EXPECT_GE(run.context.memory.peak(), bytes_of(plan, "face table") / 2);
    EXPECT_GT(bytes_of(plan, "outline"), 0);
  }
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("insitu-plan-" + std::to_string(::getpid()) + ".stl");
  std::ofstream(file) << tetrahedron_stl();
  PlannedRun run("frames: [{name: f, size: [8, 8], bodies: [{file: " + file.string() +
                 "}]}, {name: g, size: [8, 8], bodies: [{file: " + file.string() + "}]}]");
  const scene::Plan plan = run.plan();
  EXPECT_GE(run.context.memory.current(), 2 * 12 * 24) << "the file is read for each frame";
  EXPECT_EQ(run.execute(0), "");
  EXPECT_NEAR(double(run.context.memory.current()), double(plan.kept_bytes()), 4096) << plan.text();
  std::filesystem::remove(file);
}

/// Each structure that there may be is named, and where it is skipped it says why.
TEST(Plan, NamesEveryStructure) {
  PlannedRun none("frames: [{name: f, size: [8, 8], outline: {}}]");
  const scene::Plan bare = none.plan();
  PlannedRun all("frames: [{name: f, size: [8, 8], samples_per_pixel: 3, effects: [lighting], "
                 "images: [color, depth, cell], boundary: {}, outline: {}, scalar_bar: true, "
                 "time_label: true, axes: true, "
                 "volume: {field: c, smooth: true, shading: true, preintegrated: true}, "
                 "isosurfaces: [{field: p, values: [0.5], normals: smooth}]}]");
  const scene::Plan full = all.plan();
  for (const char* item : {"tree",
                           "dual mesh",
                           "face table",
                           "value ranges",
                           "macrocell grid",
                           "majorants",
                           "vertex gradients",
                           "cells around vertices",
                           "boundary faces",
                           "bodies",
                           "outline",
                           "image of a sample",
                           "image of depth",
                           "image of cells",
                           "ray marching",
                           "path tracing",
                           "lighting of surfaces",
                           "volume shading",
                           "pre-integration",
                           "step levels",
                           "scalar bar",
                           "time label",
                           "axes"})
    for (const scene::Plan* plan : {&bare, &full}) {
      const auto& entries = plan->entries();
      const auto found = std::find_if(entries.begin(), entries.end(), [&](const auto& e) {
        return e.item.rfind(item, 0) == 0 && e.item != "face table of the locator";
      });
      ASSERT_NE(found, entries.end()) << item << " in\n" << plan->text();
      EXPECT_FALSE(found->why.empty()) << item;
      const std::string name = item;
      const bool is_never = name == "dual mesh" || name == "path tracing" || name == "bodies" ||
                            name == "step levels"; // steps are even to pre-integrate
      EXPECT_EQ(found->needed, name == "tree" || name == "outline" || (plan == &full && !is_never))
          << item << " in\n"
          << plan->text();
    }
}

/// Structures are made once while neither cells nor values change, however many frames use them.
TEST(Plan, StructuresAreSharedAndKept) {
  PlannedRun run(scenes[6]);
  EXPECT_EQ(run.execute(0), "");
  const render::Structures::Counts once = run.runner.structure_counts();
  EXPECT_EQ(once.averages, 1);
  EXPECT_EQ(once.value_ranges, 2);
  EXPECT_EQ(run.execute(1), "");
  EXPECT_EQ(run.runner.structure_counts(), once);
  run.mesh.committed.commit(INSITU_CHANGED_FIELDS);
  EXPECT_EQ(run.execute(2), "");
  const render::Structures::Counts later = run.runner.structure_counts();
  EXPECT_EQ(later.averages, 1);
  EXPECT_EQ(later.averages_refreshed, 1);
  EXPECT_EQ(later.value_ranges, 2);
  EXPECT_EQ(later.value_ranges_refreshed, 2);
}

TEST(Plan, SaysWhatIsSkippedAndWhy) {
  PlannedRun run("frames: [{name: f, size: [8, 8], volume: {field: p, range: [0, 1]}}]\n"
                 "probes: [{name: q, points: [[0, 0, 0]], fields: [p, nix]}]");
  const std::string text = run.plan().text();
  for (const char* expected :
       {"frame 'f' of mesh 'test'", "needed   ray marching of 'p'",
        "skipped  value ranges of the tree", "no isosurface is asked for", "skipped  pass over 'p'",
        "skipped  lighting of surfaces", "probe 'q' of mesh 'test'", "skipped  all of it", "nix",
        "mesh 'test'\n", "skipped  dual mesh", "are kept"})
    EXPECT_NE(text.find(expected), std::string::npos) << expected << " in\n" << text;
}

/// What the samples of a volume need, and why not where it is not so.
TEST(Plan, SaysWhatIsDoneForSamples) {
  const auto text = [](const std::string& keys, const std::string& frame = {}) {
    PlannedRun run("frames: [{name: f, size: [8, 8], " + frame + "volume: {" + keys + "}}]");
    return run.plan().text();
  };
  const auto says = [](const std::string& plan, std::initializer_list<const char*> all) {
    for (const char* expected : all)
      EXPECT_NE(plan.find(expected), std::string::npos) << expected << " in\n" << plan;
  };
  says(text("field: p, shading: true, preintegrated: false"),
       {"needed   volume shading of 'p'", "skipped  lighting of surfaces", "there is none",
        "skipped  pre-integration of 'p'", "skipped  step levels of 'p'"});
  says(text("field: c, shading: true, preintegrated: true"),
       {"skipped  volume shading of 'c'", "skipped  pre-integration of 'c'",
        "the volume shows one value a cell"});
  says(text("field: p, preintegrated: true"), {"needed   pre-integration of 'p'"});
  says(text("field: p, tolerance: 0.1, shading: true"),
       {"needed   step levels of 'p'", "needed   volume shading of 'p'"});
  says(text("field: p, shading: true, tolerance: 0.1", "effects: [single_scattering], "),
       {"skipped  volume shading of 'p'", "skipped  step levels of 'p'",
        "the volume is path traced"});
  PlannedRun plain("frames: [{name: f, size: [8, 8], scalar_bar: true, boundary: {}, effects: "
                   "[shadows]}]");
  says(plain.plan().text(),
       {"skipped  scalar bar", "nothing is coloured by a field", "needed   lighting of surfaces"});
}

/// What cannot be drawn is planned as its error, and nothing else of the frame is.
TEST(Plan, SaysWhatCannotBeDrawnInTheWordsOfItsError) {
  for (const char* keys :
       {"volume: {field: nix}", "volume: {field: p, component: 7}",
        "boundary: {color: {field: nix}}", "isosurfaces: [{field: c, component: 1, values: [0]}]",
        "boundary: {}, geocentric: {globe: [1, 1, 1]}"}) {
    PlannedRun run("frames: [{name: f, size: [8, 8], " + std::string(keys) + "}]");
    const scene::Plan plan = run.plan();
    const scene::Plan::Entry& last = plan.entries().back();
    EXPECT_EQ(last.item, "all of it");
    EXPECT_EQ(run.execute(0), "frame 'f': " + last.why);
    EXPECT_EQ(plan.bytes(), 0) << plan.text();
  }
}

/// Integrals count while a frame is drawn, as many bytes as planned: exactly, as long as neither
/// opacity points nor ends of the range coincide, and nothing else is held.
TEST(Plan, TablesOfIntegralsAreCounted) {
  PlannedRun run("frames: [{name: f, size: [4, 4], volume: {field: p, range: [0, 1], opacity: "
                 "[[-1, 0.1], [2, 0.3]], nan_opacity: 1, preintegrated: true}}]");
  const scene::Plan plan = run.plan();
  EXPECT_EQ(run.execute(0), "");
  const std::int64_t planned = bytes_of(plan, "pre-integration");
  EXPECT_GT(planned, 4 * 257 * 8) << "at least four numbers a knot";
  EXPECT_EQ(run.context.memory.peak(), 4 * 4 * 16 + planned) << plan.text();
  EXPECT_EQ(run.context.memory.current(), 0);
}

/// As render::skipping_pays: cells of NaN are worth skipping unless they show.
TEST(Plan, MacrocellsAreWantedWhereSomethingMayBeEmpty) {
  const auto wants = [](const std::string& opacity) {
    PlannedRun run("frames: [{name: f, size: [8, 8], volume: {field: p, range: [0, 1], " + opacity +
                   "}}]");
    const scene::Plan plan = run.plan();
    for (const scene::Plan::Entry& e : plan.entries())
      if (e.item == "macrocell grid of 'p'")
        return e.needed;
    ADD_FAILURE() << plan.text();
    return false;
  };
  EXPECT_TRUE(wants("opacity: [[0, 0], [1, 1]], nan_opacity: 1"));
  EXPECT_TRUE(wants("opacity: [[0, 0.1], [1, 1]]"));
  EXPECT_FALSE(wants("opacity: [[0, 0.1], [1, 1]], nan_opacity: 0.5"));
}

/// On an adaptive mesh: what culling holds is in the plan, and held only if it is asked for.
TEST(Plan, CullingOfAdaptiveMeshes) {
  RegisteredAmr amr({.seed = 2, .kind = 0, .roots = 3, .levels = 4}, INSITU_DUAL,
                    [](const Vec3d& p) { return std::sin(p.x) + p.y; });
  commit::CommittedMesh* const list[] = {&amr.committed.mesh};
  const auto run = [&](const std::string& keys, const std::string& effects = {}) {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("insitu-plan-amr-" + std::to_string(::getpid()));
    core::Context context(0, amr.committed.log);
    parallel::SerialWorld world;
    scene::Statistics statistics;
    scene::Runner runner(
        scene::parse_scene_text("insitu: 1\nframes: [{name: f, size: [8, 8], " + effects +
                                    "volume: {field: f, range: [0, 1], " + keys + "}}]",
                                "s.yaml"),
        folder.string(), context, world, statistics);
    const scene::MeshList meshes{list};
    const scene::Plan plan = runner.plan(meshes);
    EXPECT_EQ(runner.execute(meshes, 0, 0.0), "");
    std::filesystem::remove_all(folder);
    for (const scene::Plan::Entry& e : plan.entries())
      if (e.item == "tree of what shows of 'f'") {
        const std::int64_t held = context.memory.current(INSITU_MEMORY_RANGES) +
                                  context.memory.current(INSITU_MEMORY_TREE);
        EXPECT_LE(held, std::max<std::int64_t>(e.bytes, 0)) << plan.text();
        EXPECT_EQ(runner.structure_counts().culled, e.needed ? 1 : 0) << plan.text();
        EXPECT_EQ(held > 0, e.needed) << plan.text();
        EXPECT_EQ(bytes_of(plan, "dual mesh"), amr.committed.mesh.amr_info().bytes);
        return std::pair(e.needed, e.why);
      }
    ADD_FAILURE() << plan.text();
    return std::pair(false, std::string());
  };
  const std::string steps = "opacity: [[0.5, 0], [0.5, 1]]";
  EXPECT_EQ(run("culling: always, " + steps), std::pair(true, std::string("culling")));
  for (const char* const never : {"", "culling: never, "})
    EXPECT_EQ(run(never + steps), std::pair(false, std::string("culling is not asked for")));
  EXPECT_FALSE(run("culling: always, preintegrated: true, " + steps).first);
}

} // namespace
} // namespace insitu::test
