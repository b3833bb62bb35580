// Effects on particles and attached points in whole runs, on a mesh that moves.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "coupled.h"
#include "unit_block.h"

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
      - remove: {when: velocity > 0.01}
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
      EXPECT_GT(counts["removed"], 0); // where the blast has come
      EXPECT_GT(counts["killed"], 0);
    } else {
      EXPECT_EQ(counts["expired"], seeded);
    }
  }
}

// A basin in longitude, latitude and depth: every effect that displaces, through a scene.
runs::Files drifters(int threads) {
  std::vector<double> lon, lat, depth, u, v, w;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 7; ++j)
      for (int i = 0; i < 7; ++i) {
        lon.push_back(175 + 2 * i > 180 ? 2 * i - 185 : 175 + 2 * i); // over the date line
        lat.push_back(60 + j);
        depth.push_back(500 * k);
        u.push_back(1.0);
        v.push_back(0.1 * i);
        w.push_back(0.0);
      }
  const test::Folder folder;
  insitu::Options options;
  options.scene_text = R"(
insitu: 1
tracers:
  - {name: beached, velocity: u, seeds: &seeds {box: {min: [176, 61, 10], max: [179, 65, 900], counts: [3, 3, 3]}},
     effects: [{boundary: slide}, {settling: {speed: 0.01}}]}
  - {name: previous, velocity: u, seeds: *seeds, effects: [{boundary: put_back}]}
  - {name: mixed, velocity: u, seeds: *seeds, effects: [{diffusion: {horizontal: 5000, vertical: 0.1}}, {boundary: reflect}]}
  - {name: stranded, velocity: u, seeds: *seeds, effects: [{boundary: stop}]}
  - {name: pearls, velocity: u, seeds: *seeds,
     effects: [{inertia: {response_time: 10, gravity: [0, 0, -0.001]}}, {coriolis: {rotation: [0, 0, 7.292115e-5]}},
               {boundary: reflect}]}
)";
  options.output = folder.path();
  options.threads = threads;
  {
    insitu::Session session(options);
    insitu::Mesh mesh = session.mesh("ocean");
    mesh.frame(insitu::Frame::geodetic(insitu::Vertical::down));
    mesh.points(lon, lat, depth);
    mesh.block(7, 7, 4);
    mesh.vertex_field("u", {u, v, w});
    for (int cycle = 0; cycle < 5; ++cycle) {
      mesh.changed(insitu::fields);
      EXPECT_TRUE(session.execute(cycle, 2e5 * cycle)) << insitu_last_message();
    }
  }
  return runs::files_of(folder.path());
}

TEST(EffectsOnParticles, DisplaceThemInLongitudeLatitudeAndDepth) {
  const runs::Files one = drifters(1);
  EXPECT_TRUE(runs::differences(one, drifters(3)).empty());
  for (const char* name : {"beached", "previous", "mixed", "stranded", "pearls"}) {
    const runs::Table t = runs::parse_table(one.at(std::string(name) + ".csv"));
    std::map<std::string, std::string> last;
    double deepest = 0;
    for (std::size_t i = 0; i < t.rows.size(); ++i) {
      last[t.text(i, "particle")] = t.text(i, "ending");
      deepest = std::max(deepest, t.number(i, "z"));
      EXPECT_LE(t.number(i, "z"), 1500);
    }
    EXPECT_EQ(last.size(), 27u) << name;
    for (const auto& [particle, ending] : last)
      EXPECT_EQ(ending, name == std::string("stranded") ? "stopped" : "killed") << name << particle;
    if (name == std::string("beached") || name == std::string("pearls")) {
      EXPECT_NEAR(deepest, 1500, 1e-3) << name; // on the floor
    }
  }
}

/// Streamlines in the cube [0, 1]^3 through u = (1, 0, 0), which sink, slide and go round.
runs::Files lines_under_effects(int threads) {
  const runs::UnitBlock block(4);
  const std::vector<double> u(block.x.size(), 1.0), zero(block.x.size(), 0.0);
  std::vector<double> salt;
  for (const double z : block.z)
    salt.push_back(35 * z);
  const test::Folder folder;
  insitu::Options options;
  options.scene_text = R"(
insitu: 1
tracers:
  - {name: round, kind: streamline, velocity: u, seeds: [[0.3, 0.5, 0.9], [0.7, 0.2, 0.05]], until: {length: 3.5},
     spacing: {length: 0.25}, output: [csv, vtp], fields: [salt],
     effects: [{settling: {speed: 0.125}}, {boundary: {periodic: [x], other: slide}}]}
  - {name: fresh, kind: streamline, velocity: u, seeds: [[0.1, 0.5, 0.9]],
     effects: [{windage: {field: u, factor: 0.5}}, {settling: {velocity: [0, 0, -1]}}, {remove: {when: salt < 17.5}}]}
)";
  options.output = folder.path();
  options.threads = threads;
  {
    insitu::Session session(options);
    insitu::Mesh mesh = session.mesh("box");
    block.hand_over(mesh);
    mesh.vertex_field("u", {u, zero, zero});
    mesh.vertex_field("salt", salt);
    EXPECT_TRUE(session.execute(0, 0.0)) << insitu_last_message();
  }
  return runs::files_of(folder.path());
}

TEST(EffectsOnStreamlines, SinkSlideGoRoundAndEndWhereAConditionHolds) {
  const runs::Files one = lines_under_effects(1);
  EXPECT_TRUE(runs::differences(one, lines_under_effects(3)).empty());
  const runs::Table t = runs::parse_table(one.at("round_000000.csv"));
  int cuts = 0;
  for (std::size_t i = 0; i < t.rows.size(); ++i) {
    const bool first = t.text(i, "line") == "0";
    const double s = t.number(i, "s"), z = std::max(0.0, (first ? 0.9 : 0.05) - 0.125 * s);
    EXPECT_NEAR(std::remainder(t.number(i, "x") - (first ? 0.3 : 0.7) - s, 1.0), 0.0, 1e-7);
    EXPECT_NEAR(t.number(i, "z"), z, 1e-7);
    EXPECT_NEAR(t.number(i, "salt"), 35 * z, 1e-5) << "on the sides as well";
    EXPECT_EQ(t.text(i, "ending"), "expired");
    cuts += i > 0 && t.text(i, "line") == t.text(i - 1, "line") && s == t.number(i - 1, "s");
  }
  EXPECT_EQ(cuts, 7); // to 0.3 + 3.47, and to 0.7 + 3.5
  const std::string& vtp = one.at("round_000000.vtp");
  EXPECT_NE(vtp.find("NumberOfLines=\"9\""), std::string::npos);
  const runs::Table fresh = runs::parse_table(one.at("fresh_000000.csv"));
  EXPECT_NEAR(fresh.number(fresh.rows.size() - 1, "x"), 0.1 + 1.5 * 0.4, 1e-9);
  EXPECT_NEAR(fresh.number(fresh.rows.size() - 1, "z"), 0.5, 1e-9);
  EXPECT_EQ(fresh.text(0, "ending"), "removed");
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
  for (std::size_t i = 0; i < 10; ++i) // 2 particles, 3 points a cycle
    for (const char* column : {"x", "y", "z"})
      EXPECT_EQ(marks.text(i, column), gauges.text(i / 2 * 3 + i % 2, column)) << column << i;
  EXPECT_NE(marks.text(8, "x"), marks.text(0, "x")); // the blast pushes them
}

const std::string ends_of_attached = R"(
insitu: 1
page: false
tracers:
  - name: marks
    attached: body
    seeds: &seeds {box: {min: [0.05, 0.05, 0.05], max: [1.1, 1.1, 1.1], counts: [6, 6, 6]}}
    fields: [velocity]
    effects: [{remove: {when: velocity > 0.01}}]
    output: [csv, netcdf]
    every: 4
  - name: aged
    attached: body
    seeds: *seeds
    release: {interval: 0.004}
    effects: [{age_limit: 0.006}, {remove: {when: velocity > 0.01 and age > 0.003}}]
    every: 4
)";

TEST(Attached, ParticlesEndByAgeAndByACondition) {
  const runs::Setup setup{.scene = ends_of_attached};
  const runs::Files whole = runs::run_to_files(setup, 20);
  runs::Setup threads = setup;
  threads.threads = 3;
  EXPECT_EQ(runs::differences(whole, runs::run_to_files(threads, 20)), std::vector<std::string>{});
  const runs::Table t = runs::parse_table(whole.at("marks.csv"));
  int removed = 0;
  for (std::size_t i = 0; i < t.rows.size(); ++i) {
    const double speed =
        std::hypot(t.number(i, "velocity_x"), t.number(i, "velocity_y"), t.number(i, "velocity_z"));
    if (t.text(i, "ending") == "removed") {
      EXPECT_GT(speed, 0.01);
      ++removed;
    } else if (t.text(i, "ending") == "alive") {
      EXPECT_LE(speed, 0.01);
    }
  }
  EXPECT_GT(removed, 10); // where the blast has come
  EXPECT_LT(removed, 200);
  std::map<std::string, int> endings;
  const runs::Table aged = runs::parse_table(whole.at("aged.csv"));
  for (std::size_t i = 0; i < aged.rows.size(); ++i)
    ++endings[aged.text(i, "ending")];
  EXPECT_GT(endings["expired"], 10);
  EXPECT_GT(endings["removed"], 10);

  // A run that stops and one that goes on from its checkpoint write the same.
  const test::Folder folder, state;
  runs::Setup parts = setup;
  parts.output = folder.path();
  {
    Coupled first(parts);
    ASSERT_TRUE(first.execute()) << insitu_last_message();
    first.run(9);
    first.session.checkpoint(state / "s");
    first.run(13);
  }
  Coupled second(parts);
  while (second.solver.cycle() < 9)
    second.solver.advance();
  second.session.restart(state / "s");
  second.run(20);
  second.session.close();
  EXPECT_EQ(runs::differences(whole, runs::files_of(folder.path())), std::vector<std::string>{});
}

} // namespace
