// Effects on particles and attached points in whole runs, on a mesh that moves.
#include <gtest/gtest.h>
#include <map>

#include "coupled.h"

namespace {

using runs::Coupled;

const char* const effects_scene = R"(
insitu: 1
every: 5
tracers:
  - name: mixed
    velocity: velocity
    seeds: {box: {min: [0.05, 0.05, 0.05], max: [1.1, 1.1, 1.1], counts: [6, 6, 6]}}
    effects:
      - settling: {speed: 2, down: [0, 0, -1]}
      - diffusion: {horizontal: 0.05, vertical: density, seed: 3}
      - boundary: reflect
      - remove: {when: density > 3}
  - name: balls
    velocity: velocity
    seeds: {box: {min: [0.05, 0.05, 0.05], max: [1.1, 1.1, 1.1], counts: [4, 4, 4]}}
    effects:
      - inertia: {response_time: 0.01, gravity: [0, 0, -100]}
      - coriolis: {rotation: [0, 0, 20]}
      - windage: {field: velocity, factor: 0.5}
      - boundary: {periodic: [x], other: slide}
      - age_limit: 0.03
)";

TEST(EffectsOnParticles, LoseNoneAndAreTheSameForAnyThreads) {
  const runs::Files one = runs::run_to_files({.scene = effects_scene, .threads = 1}, 20);
  const runs::Files three = runs::run_to_files({.scene = effects_scene, .threads = 3}, 20);
  EXPECT_TRUE(runs::differences(one, three).empty());
  for (const auto& [name, seeded] : {std::pair("mixed.csv", 216), std::pair("balls.csv", 64)}) {
    const runs::Table t = runs::parse_table(one.at(name));
    std::map<std::string, std::string> last;
    for (std::size_t i = 0; i < t.rows.size(); ++i)
      last[t.text(i, "particle")] = t.text(i, "ending");
    EXPECT_EQ(last.size(), std::size_t(seeded)) << name;
    std::map<std::string, int> counts;
    for (const auto& [particle, ending] : last)
      ++counts[ending];
    // Alive ones are killed as the session ends; what is reflected or slides does not leave.
    EXPECT_EQ(counts["alive"] + counts["left"] + counts["not_finite"] + counts["step_limit"], 0)
        << name;
    if (name == std::string("mixed.csv")) {
      EXPECT_GT(counts["removed"], 0); // behind the shock
      EXPECT_GT(counts["killed"], 0);
    } else {
      EXPECT_EQ(counts["expired"], seeded);
    }
  }
}

TEST(Attached, ProbesAndParticlesKeepTheirPlaceInTheMaterial) {
  const test::Folder folder;
  Coupled run({.scene = R"(
insitu: 1
probes:
  - {name: gauges, points: [[0.11, 0.13, 0.17], [0.31, 0.29, 0.12], [9, 9, 9]], attached: body, every: 4}
tracers:
  - {name: marks, attached: body, seeds: [[0.11, 0.13, 0.17], [0.31, 0.29, 0.12]], every: 4}
)",
               .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  run.run(16);
  run.session.close();
  const runs::Table gauges = runs::parse_table(test::content(folder / "gauges.csv"));
  ASSERT_EQ(gauges.rows.size(), 15u);
  for (std::size_t i = 3; i < 15; ++i) // the same to the last digit
    for (const char* column : {"cell", "r", "s", "t"})
      EXPECT_EQ(gauges.text(i, column), gauges.text(i % 3, column)) << column << i;
  EXPECT_EQ(gauges.text(2, "cell"), "-1");
  const runs::Table marks = runs::parse_table(test::content(folder / "marks.csv"));
  ASSERT_GE(marks.rows.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i)
    EXPECT_EQ(marks.text(i, "cell"), gauges.text(i % 2, "cell"));
  EXPECT_NE(marks.text(8, "x"), marks.text(0, "x")); // the blast pushes them
}

} // namespace
