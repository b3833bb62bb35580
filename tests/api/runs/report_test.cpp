// The report and its JSON: figures that can be checked against what the test knows.
#include <chrono>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <yaml-cpp/yaml.h>

#include "coupled.h"

namespace {

using runs::Coupled;

const std::string scene = R"(
insitu: 1
probes:
  - {name: p, points: {line: {from: [0, 0, 0], to: [1.5, 1.5, 1.5], count: 100}}, output: [csv, json]}
tracers:
  - {name: t, velocity: velocity, seeds: {sphere: {center: [0.3, 0.3, 0.3], radius: 0.2, count: 50}}}
frames:
  - {name: f, size: [48, 32], volume: {field: density}, every: 4}
)";

TEST(Report, MemoryAndTimeAddUp) {
  const test::Folder folder;
  const auto begin = std::chrono::steady_clock::now();
  Coupled run({.scene = scene, .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  run.run(8);
  const insitu::Report r = run.session.report();
  const double wall =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  EXPECT_EQ(r.executions, 9);
  EXPECT_EQ(r.keeps + r.refits + r.rebuilds, 9);
  for (const double s : {r.commit_s, r.query_s, r.advect_s, r.render_s, r.output_s})
    EXPECT_GT(s, 0.0);
  EXPECT_LT(r.commit_s + r.query_s + r.advect_s + r.render_s + r.output_s, wall);

  const auto cells = std::int64_t(run.solver.density.size()),
             vertices = std::int64_t(run.solver.x.size());
  EXPECT_EQ(r.bytes_borrowed, cells * (8 * 4 + 2 * 8) + vertices * 6 * 8);
  EXPECT_EQ(std::accumulate(std::begin(r.bytes_by_purpose), std::end(r.bytes_by_purpose),
                            std::int64_t(0)),
            r.bytes_held);
  EXPECT_GE(r.bytes_peak, r.bytes_held);
  EXPECT_GT(r.bytes_by_purpose[INSITU_MEMORY_TREE], cells * 4);
  EXPECT_LT(r.bytes_by_purpose[INSITU_MEMORY_TREE], cells * 100);
  EXPECT_GT(r.bytes_by_purpose[INSITU_MEMORY_EARLIER], vertices * 48 - 1);
  EXPECT_GT(r.bytes_by_purpose[INSITU_MEMORY_TRACER], 50 * 24);
  EXPECT_EQ(r.bytes_by_purpose[INSITU_MEMORY_CONVERTED], 0);
  for (const auto& entry : run.mesh.audit())
    EXPECT_EQ(entry.borrowed, 1) << entry.name;

  EXPECT_EQ(r.points_located, 9 * 100);
  EXPECT_GT(r.points_outside, 0);
  EXPECT_LT(r.points_outside, r.points_located);
  EXPECT_EQ(r.particles_seeded, 50);
  EXPECT_EQ(r.probe_rows, 900);
  EXPECT_EQ(r.frames, 3);
  EXPECT_EQ(r.files, 1 + 9 + 1 + 3 + 1 + 2); // the last: the table of frames, the page of the run
  EXPECT_EQ(r.files, std::int64_t(runs::files_of(folder.path()).size()));
  EXPECT_EQ(r.failures, 0);
}

TEST(Report, MemoryDoesNotGrowFromCycleToCycle) {
  const test::Folder folder;
  // One builder: which the library chooses, and when, depends on measured times.
  Coupled run({.scene = scene + "locator: {builder: morton}\n", .output = folder.path()});
  ASSERT_TRUE(run.execute());
  run.run(8);
  const insitu::Report before = run.session.report();
  run.run(32);
  const insitu::Report after = run.session.report();
  // A builder's scratch stays for the few cycles after a rebuild.
  const auto lasting = [](const insitu::Report& r) {
    return r.bytes_held - r.bytes_by_purpose[INSITU_MEMORY_BUILD];
  };
  EXPECT_LE(lasting(after), lasting(before));
  // In a cycle of both, a frame's image and the builder's scratch are there at once.
  constexpr std::int64_t image = 48 * 32 * 4 * sizeof(float);
  EXPECT_LE(after.bytes_peak, before.bytes_peak * 11 / 10 + image);
}

// Particles that have ended are in the table, and needed no more.
TEST(Report, AStreaklineOfShortLivesHoldsAsMuchAsItsLivingParticles) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\ntracers:\n  - {name: t, kind: streakline, velocity: velocity, "
                        "every: 50, until: {duration: 0.001}, seeds: {sphere: {center: "
                        "[0.3, 0.3, 0.3], radius: 0.2, count: 200}}}\n",
               .output = folder.path(),
               .cells = 6});
  ASSERT_TRUE(run.execute());
  run.run(10);
  const std::int64_t before = run.session.report().bytes_by_purpose[INSITU_MEMORY_TRACER];
  run.run(60);
  const insitu::Report r = run.session.report();
  EXPECT_EQ(r.particles_seeded, 61 * 200);
  EXPECT_LE(r.bytes_by_purpose[INSITU_MEMORY_TRACER], before);
}

TEST(Report, ThePlanIsToldBeforeAnythingIsDone) {
  const test::Folder folder;
  Coupled run({.scene = scene, .output = folder.path()});
  const std::string plan = run.session.plan();
  EXPECT_NE(plan.find("skipped  lighting of surfaces"), std::string::npos) << plan;
  EXPECT_EQ(run.session.report().executions, 0);
  EXPECT_EQ(run.session.report().files, 0);
  Coupled bare({.scene = "", .output = folder.path()});
  EXPECT_EQ(bare.session.plan(), "");
  EXPECT_EQ(insitu_session_plan(nullptr, nullptr), INSITU_ERROR_HANDLE);
}

TEST(Report, RangesAreFoundAgainForNewValuesAndClassifiedOnlyThen) {
  const test::Folder folder;
  Coupled run({.scene = R"(
insitu: 1
frames:
  - {name: p, size: [16, 16], volume: {field: density}, path_tracing: {samples: 1}}
  - {name: s, size: [16, 16], isosurfaces: [{field: density, values: [2]}]}
)",
               .output = folder.path()});
  EXPECT_EQ(run.session.report().ranges_s, 0.0);
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  const insitu::Report first = run.session.report();
  EXPECT_GT(first.ranges_s, 0.0);
  EXPECT_GT(first.classify_s, 0.0);
  EXPECT_LT(first.ranges_s + first.classify_s, first.render_s);
  ASSERT_TRUE(run.execute()); // of nothing new
  const insitu::Report same = run.session.report();
  EXPECT_GT(same.render_s, first.render_s);
  EXPECT_EQ(same.ranges_s, first.ranges_s);
  EXPECT_EQ(same.classify_s, first.classify_s);
  run.run(1, insitu::fields);
  const insitu::Report later = run.session.report();
  EXPECT_GT(later.ranges_s, same.ranges_s);
  EXPECT_GT(later.classify_s, same.classify_s);
  EXPECT_LT(later.ranges_s + later.classify_s, later.render_s);
}

TEST(Report, TheSummaryIsJson) {
  const test::Folder folder;
  Coupled run({.scene = scene, .output = folder.path()});
  ASSERT_TRUE(run.execute());
  run.run(4);
  run.session.write_summary(folder / "summary.json", 2.0);
  const insitu::Report r = run.session.report();
  const YAML::Node json = YAML::LoadFile(folder / "summary.json"); // JSON is YAML
  EXPECT_EQ(json["executions"].as<int>(), 5);
  EXPECT_EQ(json["commits"]["refit"].as<std::int64_t>(), r.refits);
  EXPECT_EQ(json["seconds"]["commit"].as<double>(), r.commit_s);
  EXPECT_EQ(json["seconds"]["render_ranges"].as<double>(), r.ranges_s);
  EXPECT_EQ(json["seconds"]["render_classify"].as<double>(), r.classify_s);
  const double library = json["seconds"]["library"].as<double>();
  EXPECT_NEAR(json["seconds"]["library_share"].as<double>(), library / (library + 2.0), 1e-12);
  EXPECT_EQ(json["bytes"]["held"].as<std::int64_t>(), r.bytes_held);
  std::int64_t held = 0, particles = 0;
  for (const auto& purpose : json["bytes"]["held_by_purpose"])
    held += purpose.second.as<std::int64_t>();
  EXPECT_EQ(held, r.bytes_held);
  for (const auto& ending : json["particles"])
    if (ending.first.as<std::string>() != "seeded")
      particles += ending.second.as<std::int64_t>();
  EXPECT_EQ(particles, json["particles"]["seeded"].as<std::int64_t>());
  EXPECT_EQ(json["failures"].as<int>(), 0);
  std::int64_t located = 0;
  const char* const reasons[] = {"outside", "certified", "exact",
                                 "on_face", "on_edge",   "on_vertex"};
  for (int k = 0; k < INSITU_REASON_COUNT; ++k) {
    EXPECT_EQ(json["located_by_reason"][reasons[k]].as<std::int64_t>(), r.located_by_reason[k]);
    located += r.located_by_reason[k];
  }
  // The probe's points, every one; the tracers' and the frame's come on top.
  EXPECT_GT(located, r.points_located);
  EXPECT_GE(r.located_by_reason[INSITU_REASON_OUTSIDE], r.points_outside);
  EXPECT_GE(r.located_by_reason[INSITU_REASON_ON_VERTEX], 5); // the line starts in a corner
}

TEST(Report, NumbersThatJsonLacksAreNull) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\n", .output = folder.path()});
  run.session.write_summary(folder / "infinite.json", std::numeric_limits<double>::infinity());
  const std::string text = test::content(folder / "infinite.json");
  EXPECT_NE(text.find("\"solver\": null"), std::string::npos) << text;
  EXPECT_EQ(text.find("inf"), std::string::npos) << text;
  run.session.write_summary(folder / "nan.json", std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(test::content(folder / "nan.json").find("solver"), std::string::npos);
}

} // namespace
