// Particles on the moving mesh: none is lost, and those carried by the material stay at their place
// in it.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <iostream>
#include <map>
#include <numeric>

#include "coupled.h"
#include "unit_block.h"

namespace {

using runs::Coupled;

std::int64_t sum_of_endings(const insitu::Report& r) {
  return std::accumulate(std::begin(r.particles), std::end(r.particles), std::int64_t(0));
}

TEST(Particles, TheEarlierStepIsHeldWhileAPathlineLivesAndOnlyThen) {
  const auto earlier = [](const Coupled& run) {
    return run.session.report().bytes_by_purpose[INSITU_MEMORY_EARLIER];
  };
  const test::Folder folder;
  Coupled none({.scene = "insitu: 1\nprobes:\n  - {name: p, points: [[0.1, 0.1, 0.1]]}\n"
                         "tracers:\n  - {name: s, kind: streamline, velocity: velocity, "
                         "seeds: [[0.1, 0.1, 0.1]]}\n",
                .output = folder.path()});
  ASSERT_TRUE(none.execute());
  EXPECT_EQ(earlier(none), 0);
  none.run(2);
  EXPECT_EQ(earlier(none), 0);

  Coupled run({.scene = "insitu: 1\ntracers:\n  - {name: t, velocity: velocity, "
                        "seeds: [[0.1, 0.1, 0.1]], until: {duration: 0.02}}\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute());
  const auto vertices = std::int64_t(run.solver.x.size());
  // Coordinates and velocity; the cells' ids in 32 bits.
  EXPECT_EQ(earlier(run), vertices * 48 + std::int64_t(run.solver.connectivity.size()) * 4);
  while (run.solver.time() <= 0.02)
    ASSERT_TRUE(run.step());
  EXPECT_EQ(run.session.report().particles[INSITU_END_EXPIRED], 1);
  EXPECT_EQ(earlier(run), 0);
}

/// The way of particles through the blast, by the scene's further keys.
std::string way_by(const std::string& keys, insitu::Change changed, std::int64_t* bytes = nullptr) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\npage: false\ntracers:\n  - {name: t, velocity: velocity, "
                        "seeds: [[0.2, 0.1, 0.1], [0.3, 0.2, 0.1]]" +
                        keys + "}\n",
               .output = folder.path()});
  EXPECT_TRUE(run.execute()) << insitu_last_message();
  run.run(6, changed);
  if (bytes) // a vertex, but for the copy of the cells
    *bytes = (run.session.report().bytes_by_purpose[INSITU_MEMORY_EARLIER] -
              std::int64_t(run.solver.connectivity.size()) * 4) /
             std::int64_t(run.solver.x.size());
  run.session.close();
  return test::content(folder / "t.csv");
}

// Each further step costs its copy of the velocity, and of the wind that goes with it.
TEST(Particles, InterpolateInTimeThroughAsManyStepsAsAreAsked) {
  const auto moving = insitu::geometry | insitu::fields;
  std::int64_t bytes[4] = {};
  const std::string linear = way_by("", moving, &bytes[0]);
  EXPECT_EQ(way_by(", time_interpolation: linear", moving), linear);
  const std::string quadratic = way_by(", time_interpolation: quadratic", moving, &bytes[1]);
  const std::string cubic = way_by(", time_interpolation: cubic", moving, &bytes[2]);
  const std::string wind = ", effects: [{windage: {field: velocity, factor: 0.1}}]";
  const std::string blown = way_by(wind + ", time_interpolation: cubic", moving, &bytes[3]);
  EXPECT_NE(quadratic, linear);
  EXPECT_NE(cubic, linear);
  EXPECT_NE(cubic, quadratic);
  EXPECT_NE(blown, way_by(wind, moving));
  for (int kind = 0; kind < 4; ++kind) {
    const int copies = std::min(kind, 2) + 2; // of coordinates, and of the velocity
    EXPECT_EQ(bytes[kind], 24 * copies);
  }
  // The same rows up to where the third step is known, and others from there.
  const auto rows = [](const std::string& text) { return runs::parse_table(text).rows; };
  EXPECT_EQ(rows(cubic)[3], rows(linear)[3]);
  EXPECT_NE(rows(cubic)[5], rows(linear)[5]);
  EXPECT_EQ(rows(cubic)[5], rows(quadratic)[5]);
  EXPECT_NE(rows(cubic)[7], rows(quadratic)[7]);
}

// A change of topology leaves the step before it and none older, for any interpolation: at every
// step, so that what comes out is the straight line, and not the current velocity alone.
TEST(Particles, KnowOneEarlierStepAfterAChangeOfTopology) {
  const auto moving = insitu::geometry | insitu::fields;
  const auto all = moving | insitu::topology;
  const std::string linear = way_by("", all);
  EXPECT_EQ(way_by(", time_interpolation: cubic", all), linear);
  // The cells are the same ones, which go with the flow: blended in space or in the material, the
  // ways differ by the square of a step.
  const runs::Table across = runs::parse_table(linear),
                    same = runs::parse_table(way_by("", moving));
  ASSERT_EQ(across.rows.size(), same.rows.size());
  for (std::size_t i = 0; i < same.rows.size(); ++i)
    EXPECT_NEAR(across.number(i, "x"), same.number(i, "x"), 1e-4) << i;
}

TEST(Particles, NoneIsLostAtAnyCycle) {
  const test::Folder folder;
  Coupled run({.scene = R"(
insitu: 1
tracers:
  - name: paths
    velocity: velocity
    fields: [density]
    seeds: {box: {min: [-0.1, 0.05, 0.05], max: [1.3, 1.15, 1.15], counts: [8, 5, 5]}}
    until: {length: 0.05}
    every: 7
  - name: streaks
    kind: streakline
    velocity: velocity
    seeds: [[0.1, 0.1, 0.1], [0.2, 0.1, 0.1], [5, 5, 5]]
    until: {duration: 0.03}
    output: [csv, vtp]
    every: 7
  - {name: lines, kind: streamline, velocity: velocity, seeds: [[0.2, 0.2, 0.2], [9, 9, 9]], every: 7}
)",
               .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  for (int cycle = 1; cycle <= 40; ++cycle) {
    ASSERT_TRUE(run.step()) << insitu_last_message();
    const insitu::Report r = run.session.report();
    EXPECT_EQ(r.particles_seeded, 200 + 3 * (cycle + 1) + 2 * (cycle / 7 + 1)) << cycle;
    EXPECT_EQ(sum_of_endings(r), r.particles_seeded) << cycle;
  }
  const insitu::Report r = run.session.report();
  EXPECT_EQ(r.particles[INSITU_END_KILLED], 0);
  EXPECT_GT(r.particles[INSITU_END_ALIVE], 0);
  EXPECT_GT(r.particles[INSITU_END_EXPIRED], 0);
  run.session.close();

  // In the tables each particle has one last row, with its ending, and none after it.
  for (const auto& [name, seeded] : {std::pair("paths.csv", 200), std::pair("streaks.csv", 123)}) {
    const runs::Table t = runs::parse_table(test::content(folder / name));
    std::map<std::string, std::string> last;
    for (std::size_t i = 0; i < t.rows.size(); ++i) {
      std::string& ending = last[t.text(i, "particle")];
      EXPECT_TRUE(ending.empty() || ending == "alive") << name << ", row " << i;
      ending = t.text(i, "ending");
    }
    EXPECT_EQ(last.size(), std::size_t(seeded)) << name;
    std::map<std::string, int> counts;
    for (const auto& [particle, ending] : last)
      ++counts[ending];
    EXPECT_EQ(counts.count("alive"), 0u) << name;
    EXPECT_GT(counts["expired"], 0) << name;
    EXPECT_GT(counts["killed"], 0) << name;
    EXPECT_GT(counts["seed_outside"], 0) << name;
  }
}

// A particle's row of its ending carries the cycle in which it ended, not the next due one.
TEST(Particles, AnEndingIsWrittenInItsOwnCycle) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\ntracers:\n  - {name: t, velocity: velocity, every: 100, "
                        "fields: [density], seeds: [[0.1, 0.1, 0.1]], until: {duration: 0.01}}\n",
               .output = folder.path()});
  ASSERT_TRUE(run.execute());
  while (run.session.report().particles[INSITU_END_EXPIRED] == 0)
    ASSERT_TRUE(run.step());
  const int ended = run.solver.cycle();
  run.run(ended + 5);
  run.session.close();
  const runs::Table t = runs::parse_table(test::content(folder / "t.csv"));
  ASSERT_EQ(t.rows.size(), 2u);
  EXPECT_EQ(t.number(1, "cycle"), ended);
  EXPECT_DOUBLE_EQ(t.number(1, "time"), 0.01);
  EXPECT_EQ(t.text(1, "ending"), "expired");
  EXPECT_GT(t.number(1, "density"), 0.0);
}

TEST(Particles, TimeThatGoesBackIsRefusedAndHarmsNothing) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\ntracers:\n  - {name: t, kind: streakline, velocity: velocity, "
                        "seeds: [[0.1, 0.1, 0.1]]}\n",
               .output = folder.path()});
  ASSERT_TRUE(run.session.execute(0, 1.0));
  EXPECT_FALSE(run.session.execute(1, 0.5));
  EXPECT_NE(std::string(insitu_last_message()).find("time went back"), std::string::npos)
      << insitu_last_message();
  EXPECT_EQ(run.session.report().particles_seeded, 1);
  EXPECT_TRUE(run.session.execute(2, 1.0)) << insitu_last_message();
  EXPECT_EQ(run.session.report().particles_seeded, 2);
}

// The mesh moves with the material, so a particle that the flow carries keeps its cell and its
// parametric coordinates, through every refit. What it drifts is the error of the solver's
// positions (moved with mean velocities) against the integrated ones: of second order in the
// timestep within a step, and of first over a run.
TEST(Particles, TheMaterialCarriesThem) {
  constexpr int cells = 10, cycles = 40;
  const test::Folder folder;
  std::string seeds;
  std::vector<std::array<double, 3>> places;
  for (int i = 0; i < 60; ++i) // strictly inside cells, most of them where the shock passes
    places.push_back({1.2 / cells * (i % 5 + 0.2 + 0.1 * (i % 4)),
                      1.2 / cells * (i / 5 % 4 + 0.3 + 0.05 * (i % 7)),
                      1.2 / cells * (i / 20 + 0.25 + 0.07 * (i % 6))});
  for (const auto& p : places)
    seeds += (seeds.empty() ? "[" : ", [") + std::to_string(p[0]) + ", " + std::to_string(p[1]) +
             ", " + std::to_string(p[2]) + "]";
  Coupled run({.scene = "insitu: 1\ntracers:\n  - {name: t, velocity: velocity, integrator: "
                        "{method: dopri5, tolerance: 1e-9}, seeds: [" +
                        seeds + "]}\n",
               .output = folder.path(),
               .cells = cells});
  ASSERT_TRUE(run.execute());
  const auto locate = [&] {
    const runs::Table t = runs::parse_table(test::content(folder / "t.csv"));
    const std::size_t n = places.size(), first = t.rows.size() - n;
    std::vector<std::array<double, 3>> now(n);
    for (std::size_t i = 0; i < n; ++i)
      now[i] = {t.number(first + i, "x"), t.number(first + i, "y"), t.number(first + i, "z")};
    return std::pair(run.mesh.locate(now), now);
  };
  const auto [began, from] = locate();
  double drift = 0.0, moved = 0.0;
  for (int cycle = 1; cycle <= cycles; ++cycle) {
    ASSERT_TRUE(run.step()) << insitu_last_message();
    const auto [now, at] = locate();
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_EQ(now.cells[i], began.cells[i]) << "particle " << i << ", cycle " << cycle;
      for (int c = 0; c < 3; ++c) {
        drift = std::max(drift, std::abs(now.parametric[3 * i + c] - began.parametric[3 * i + c]));
        moved = std::max(moved, std::abs(at[i][c] - from[i][c]) * cells / 1.2);
      }
    }
  }
  EXPECT_GT(run.session.report().refits, cycles / 2);
  std::cout << "largest drift of a parametric coordinate over " << cycles << " cycles: " << drift
            << "; the particles moved by up to " << moved << " cells\n";
  EXPECT_GT(moved, 1.0);
  EXPECT_LT(drift, 0.001);
}

// Cells of one velocity each: over the jump at x = 0.5 no step keeps the tolerance.
TEST(Accounting, StuckParticlesEndWithTheReason) {
  const runs::UnitBlock block(4);
  std::vector<double> u, v, w;
  for (int c = 0; c < 64; ++c) {
    u.push_back(c % 4 < 2 ? 1.0 : 0.5);
    v.push_back(c % 4 < 2 ? 0.0 : 0.25);
    w.push_back(0.0);
  }
  const test::Folder folder;
  insitu::Options options;
  options.scene_text = R"(
insitu: 1
tracers:
  - {name: stuck, velocity: u, seeds: &seeds [[0.2, 0.3, 0.6], [0.6, 0.3, 0.6]],
     integrator: {face_aware: false, min_step: 1e-3}}
  - {name: forced, velocity: u, seeds: *seeds,
     integrator: {face_aware: false, min_step: 1e-3, at_min_step: take}}
  - {name: lines, kind: streamline, velocity: u, seeds: *seeds, output: [csv, vtp],
     integrator: {face_aware: false, min_step: 1e-3}}
)";
  options.output = folder.path();
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("box");
  block.hand_over(mesh);
  mesh.cell_field("u", {u, v, w});
  for (int cycle = 0; cycle < 3; ++cycle) {
    mesh.changed(insitu::fields);
    ASSERT_TRUE(session.execute(cycle, 0.2 * cycle)) << insitu_last_message();
    const insitu::Report r = session.report();
    EXPECT_EQ(sum_of_endings(r), r.particles_seeded);
    EXPECT_EQ(r.particles[INSITU_END_STEP_TOO_SMALL], cycle < 2 ? cycle + 1 : 4);
  }
  session.write_summary(folder / "summary.json");
  session.close();
  EXPECT_NE(test::content(folder / "summary.json").find("\"step_too_small\": 4"),
            std::string::npos);
  const auto last = [&](const char* file, const char* key, const char* line) {
    const runs::Table t = runs::parse_table(test::content(folder / file));
    std::size_t row = 0;
    for (std::size_t i = 0; i < t.rows.size(); ++i)
      if (t.text(i, key) == line)
        row = i;
    return std::pair(t.text(row, "ending"), t.number(row, "x"));
  };
  for (const auto& [ending, at] :
       {last("stuck.csv", "particle", "0"), last("lines_000002.csv", "line", "0")}) {
    EXPECT_EQ(ending, "step_too_small");
    EXPECT_LE(at, 0.5);
    EXPECT_GE(at, 0.5 - 1e-3);
  }
  EXPECT_EQ(last("stuck.csv", "particle", "1").first, "killed");
  EXPECT_EQ(last("forced.csv", "particle", "0").first, "killed");
  EXPECT_NEAR(last("forced.csv", "particle", "0").second, 0.55, 1e-3);
}

} // namespace
