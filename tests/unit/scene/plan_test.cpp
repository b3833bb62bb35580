// What a plan says is what is made: bytes and counts of a run's structures against its plan.
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>

#include "../query/registered_amr.h"
#include "../render/render_mesh.h"
#include "core/context.h"
#include "scene/parse.h"
#include "scene/runner.h"
#include "scene_test.h"

namespace insitu::test {
namespace {

struct PlannedRun {
  explicit PlannedRun(const std::string& items)
      : folder(std::filesystem::temp_directory_path() /
               ("insitu-plan-" + std::to_string(::getpid()))),
        context(0, mesh.committed.log),
        runner(scene::parse_scene_text("insitu: 1\n" + items, "s.yaml"), folder.string(), context,
               statistics) {
    mesh.field("p", INSITU_VERTEX, [](const Vec3d& p) { return p.x + p.y * p.z; });
    mesh.field("c", INSITU_CELL, [](const Vec3d& p) { return p.x - p.y; });
  }
  ~PlannedRun() { std::filesystem::remove_all(folder); }

  scene::Plan plan() { return runner.plan(meshes); }
  std::string execute(std::int64_t cycle) { return runner.execute(meshes, cycle, double(cycle)); }

  RenderMesh mesh{7, Shape::hexahedron, 0.2};
  std::filesystem::path folder;
  core::Context context;
  scene::Statistics statistics;
  scene::Runner runner;
  query::CommittedMesh* list[1] = {&mesh.committed.mesh};
  scene::MeshList meshes{list};
};

/// Of what stays from one cycle to the next.
std::int64_t kept_bytes(const scene::Plan& plan) {
  std::int64_t sum = 0;
  for (const scene::Plan::Entry& e : plan.entries())
    if (e.needed && !e.shared && e.bytes > 0 && e.item.rfind("image", 0) != 0)
      sum += e.bytes;
  return sum;
}

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
    const core::Memory& memory = run.context.memory;
    const scene::Plan plan = run.plan();
    EXPECT_EQ(memory.current(), 0) << "a plan makes nothing";
    for (std::int64_t cycle = 0; cycle < 2; ++cycle) {
      EXPECT_EQ(run.execute(cycle), "");
      EXPECT_EQ(memory.current(), kept_bytes(plan)) << plan.text();
    }
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
        "skipped  lighting", "probe 'q' of mesh 'test'", "skipped  all of it", "nix",
        "beside the trees, at most 1.0 kB"})
    EXPECT_NE(text.find(expected), std::string::npos) << expected << " in\n" << text;
}

/// As render::skipping_pays: cells of NaN are worth skipping unless they show.
TEST(Plan, MacrocellsAreWantedWhereSomethingMayBeEmpty) {
  const auto wants = [](const std::string& opacity) {
    PlannedRun run("frames: [{name: f, size: [8, 8], volume: {field: p, range: [0, 1], " + opacity +
                   "}}]");
    const scene::Plan plan = run.plan();
    for (const scene::Plan::Entry& e : plan.entries())
      if (e.item == "macrocells of 'p'")
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
  query::CommittedMesh* const list[] = {&amr.committed.mesh};
  const auto run = [&](const std::string& keys, const std::string& effects = {}) {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("insitu-plan-amr-" + std::to_string(::getpid()));
    core::Context context(0, amr.committed.log);
    scene::Statistics statistics;
    scene::Runner runner(
        scene::parse_scene_text("insitu: 1\nframes: [{name: f, size: [8, 8], " + effects +
                                    "volume: {field: f, range: [0, 1], " + keys + "}}]",
                                "s.yaml"),
        folder.string(), context, statistics);
    const scene::MeshList meshes{list};
    const scene::Plan plan = runner.plan(meshes);
    EXPECT_EQ(runner.execute(meshes, 0, 0.0), "");
    std::filesystem::remove_all(folder);
    for (const scene::Plan::Entry& e : plan.entries())
      if (e.item == "tree of what shows of 'f'") {
        const std::int64_t held = context.memory.current(INSITU_MEMORY_RANGES) +
                                  context.memory.current(INSITU_MEMORY_TREE);
        EXPECT_LE(held, std::max<std::int64_t>(e.bytes, 0)) << plan.text();
        EXPECT_EQ(runner.structure_counts().culled, e.needed && e.bytes > 0 ? 1 : 0) << plan.text();
        EXPECT_EQ(held > 0, e.needed && e.bytes > 0) << plan.text();
        return std::pair(e.needed, e.why);
      }
    ADD_FAILURE() << plan.text();
    return std::pair(false, std::string());
  };
  const std::string steps = "opacity: [[0.5, 0], [0.5, 1]]";
  EXPECT_EQ(run("culling: always, " + steps), std::pair(true, std::string("at most; culling")));
  EXPECT_TRUE(run(steps).first); // if it pays, which it does not for so few rays
  EXPECT_FALSE(run("culling: never, " + steps).first);
  EXPECT_FALSE(run("culling: always, preintegrated: true, " + steps).first);
  EXPECT_FALSE(run("opacity: [[0, 1]], nan_opacity: 1").first);
}

} // namespace
} // namespace insitu::test
