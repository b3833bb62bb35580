// Meshes without cells, with ghosts only, of several pieces, or that go bad during a run.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "coupled.h"

namespace {

using runs::Coupled;

const std::string scene = R"(
insitu: 1
probes:
  - {name: p, points: {line: {from: [0.05, 0.05, 0.05], to: [0.9, 0.9, 0.9], count: 10}}, output: [csv, vtp, json]}
tracers:
  - {name: t, velocity: velocity, seeds: [[0.3, 0.3, 0.3]], output: [csv, vtp]}
  - {name: s, kind: streakline, velocity: velocity, seeds: [[0.3, 0.3, 0.3]]}
  - {name: l, kind: streamline, velocity: velocity, seeds: [[0.3, 0.3, 0.3]], output: [csv, vtp]}
frames:
  - {name: f, size: [24, 16], volume: {field: density}, time_label: true}
  - {name: g, size: [24, 16], isosurfaces: [{field: density, values: [1.5]}]}
)";

// Probes and tracers have an answer, outside; there is nothing that a frame could show, which is no
// failure, and it says so once.
void expect_outside_and_no_frames(Coupled& run, const std::string& folder,
                                  const char* ending = "seed_outside") {
  for (int cycle = 0; cycle < 3; ++cycle) {
    EXPECT_EQ(insitu_session_execute(run.session.handle(), cycle, cycle), INSITU_OK)
        << insitu_last_message();
  }
  EXPECT_EQ(run.session.report().failures, 0);
  ASSERT_EQ(run.log.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NE(run.log[i].find(std::string("frame '") + "fg"[i] +
                              "': mesh 'hydro' has no cell that could be drawn"),
              std::string::npos)
        << run.log[i];
  run.session.close();
  const runs::Files files = runs::files_of(folder);
  EXPECT_TRUE(runs::names_of(files, ".png").empty());
  const runs::Table p = runs::parse_table(files.at("p.csv"));
  EXPECT_EQ(p.rows.size(), 30u);
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    EXPECT_EQ(p.text(i, "cell"), "-1");
    EXPECT_EQ(p.text(i, "density"), "");
  }
  const runs::Table t = runs::parse_table(files.at("t.csv"));
  ASSERT_EQ(t.rows.size(), 1u);
  EXPECT_EQ(t.text(0, "ending"), ending);
}

TEST(Meshes, AnEmptyOne) {
  const test::Folder folder;
  Coupled run({.scene = scene, .output = folder.path()});
  const std::vector<double> none;
  const std::vector<std::int32_t> no_cells;
  run.mesh.points(none, none, none);
  run.mesh.hexahedra(no_cells);
  run.mesh.cell_field("density", none);
  run.mesh.cell_field("pressure", none);
  run.mesh.vertex_field("velocity", {none, none, none});
  expect_outside_and_no_frames(run, folder.path());
}

// A rank whose cells arrive later, and leave again.
TEST(Meshes, CellsThatComeAndGo) {
  const test::Folder folder;
  Coupled run({.scene = scene, .output = folder.path()});
  const std::vector<double> none;
  const std::vector<std::int32_t> no_cells;
  const auto give = [&](bool cells) {
    sedov::Solver& s = run.solver;
    run.mesh.points(cells ? s.x : none, cells ? s.y : none, cells ? s.z : none);
    run.mesh.hexahedra(cells ? s.connectivity : no_cells);
    run.mesh.cell_field("density", cells ? s.density : none);
    run.mesh.cell_field("pressure", cells ? s.pressure : none);
    run.mesh.vertex_field("velocity", {cells ? s.u : none, cells ? s.v : none, cells ? s.w : none});
  };
  for (int cycle = 0; cycle < 9; ++cycle) {
    give(cycle / 3 != 1);
    if (cycle > 0)
      run.solver.advance();
    EXPECT_TRUE(run.session.execute(cycle, run.solver.time())) << insitu_last_message();
  }
  const insitu::Report r = run.session.report();
  EXPECT_EQ(r.failures, 0);
  EXPECT_EQ(r.frames, 6 * 2);
  EXPECT_EQ(r.particles_seeded, 1 + 9 + 9);
  run.session.close();
  const runs::Table p = runs::parse_table(test::content(folder / "p.csv"));
  ASSERT_EQ(p.rows.size(), 90u);
  for (std::size_t i = 0; i < p.rows.size(); ++i)
    EXPECT_EQ(p.text(i, "cell") == "-1", i / 30 == 1) << "row " << i;
}

TEST(Meshes, GhostsOnly) {
  const test::Folder folder;
  Coupled run({.scene = scene, .output = folder.path()});
  const std::vector<std::uint8_t> ghosts(run.solver.density.size(), 1);
  run.mesh.ghosts(ghosts);
  expect_outside_and_no_frames(run, folder.path(), "partition");
}

TEST(Meshes, NoneAtAll) {
  insitu::Options options;
  const test::Folder folder;
  options.scene_text = scene;
  options.output = folder.path();
  std::vector<std::string> log;
  options.log = [&](insitu::LogLevel, const char* message) { log.emplace_back(message); };
  insitu::Session session(options);
  EXPECT_FALSE(session.execute(0, 0.0));
  EXPECT_NE(std::string(insitu_last_message()).find("the session has no mesh"), std::string::npos);
  (void)session.mesh("nothing given yet");
  EXPECT_TRUE(session.execute(1, 1.0)) << insitu_last_message(); // no cells add nothing
}

// A vertex that turns NaN, in a mesh that was validated before: refused, by name, until it is
// mended.
TEST(Meshes, AVertexThatTurnsNan) {
  const test::Folder folder;
  Coupled run({.scene = scene, .output = folder.path()});
  ASSERT_TRUE(run.execute());
  double& x = run.solver.x.back();
  const double before = x;
  for (const insitu::Change changed : {insitu::geometry, insitu::topology}) {
    x = std::numeric_limits<double>::quiet_NaN();
    run.mesh.changed(changed);
    try {
      run.session.execute(1, 0.001);
      FAIL() << "a NaN coordinate was accepted";
    } catch (const insitu::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_MESH);
      EXPECT_NE(std::string(e.what()).find("hydro"), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find("999"), std::string::npos) << e.what();
    }
    EXPECT_THROW((void)run.mesh.locate(std::vector<double>{0.3, 0.3, 0.3}), insitu::Error);
    x = before;
    run.mesh.changed(insitu::geometry);
    EXPECT_TRUE(run.session.execute(2, 0.002)) << insitu_last_message();
    EXPECT_EQ(run.mesh.locate(std::vector<double>{1.19, 1.19, 1.19}).cells[0], 999);
  }
  EXPECT_EQ(run.session.report().failures, 0);
}

// Cells are told by piece and the piece's own number, in every output.
TEST(Meshes, SeveralPieces) {
  const test::Folder folder;
  insitu::Options options;
  options.scene_text = R"(
insitu: 1
probes:
  - {name: p, points: [[0.5, 0.5, 0.5], [1.75, 0.5, 0.5], [3, 3, 3]], fields: [f], output: [csv, json]}
tracers:
  - {name: t, velocity: velocity, fields: [f], seeds: [[0.6, 0.5, 0.5]], integrator: {method: rk4}}
  - {name: l, kind: streamline, velocity: velocity, seeds: [[0.6, 0.5, 0.5]], until: {duration: 0.7}}
)";
  options.output = folder.path();
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("two");
  const std::vector<double> f0(1, 7.0), f1(2, 9.0), one(12, 1.0), zero(12, 0.0);
  mesh.piece(0).uniform_block({2, 2, 2}, {0, 0, 0}, {1, 1, 1});
  mesh.piece(0).cell_field("f", f0);
  mesh.piece(0).vertex_field(
      "velocity",
      {insitu::Array(one.data(), 8), insitu::Array(zero.data(), 8), insitu::Array(zero.data(), 8)});
  mesh.piece(1).uniform_block({3, 2, 2}, {1, 0, 0}, {0.5, 1, 1});
  mesh.piece(1).cell_field("f", f1);
  mesh.piece(1).vertex_field("velocity", {one, zero, zero});
  ASSERT_TRUE(session.execute(0, 0.0)) << insitu_last_message();
  ASSERT_TRUE(session.execute(1, 1.0)) << insitu_last_message();
  session.close();
  const runs::Table p = runs::parse_table(test::content(folder / "p.csv"));
  ASSERT_EQ(p.rows.size(), 6u);
  const char* expected[][3] = {{"0", "0", "7"}, {"1", "1", "9"}, {"-1", "-1", ""}};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(p.text(i, "cell"), expected[i % 3][0]);
    EXPECT_EQ(p.text(i, "piece"), expected[i % 3][1]);
    EXPECT_EQ(p.text(i, "f"), expected[i % 3][2]);
  }
  const std::string json = test::content(folder / "p_000000.json");
  EXPECT_NE(json.find(R"(["cell", "piece", "f"])"), std::string::npos) << json;
  EXPECT_NE(json.find("[1, 1, 9]"), std::string::npos) << json;
  const runs::Table t = runs::parse_table(test::content(folder / "t.csv"));
  ASSERT_EQ(t.rows.size(), 3u);
  EXPECT_EQ(t.text(0, "piece"), "0");
  EXPECT_EQ(t.text(1, "piece"), "1");
  EXPECT_EQ(t.text(1, "cell"), "1");
  EXPECT_NEAR(t.number(1, "x"), 1.6, 1e-12);
  EXPECT_EQ(t.text(1, "f"), "9");
  const runs::Table l = runs::parse_table(test::content(folder / "l_000000.csv"));
  EXPECT_EQ(l.text(l.rows.size() - 1, "piece"), "1");
  EXPECT_EQ(l.text(l.rows.size() - 1, "cell"), "0");
}

} // namespace
