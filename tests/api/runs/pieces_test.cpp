// Pieces that come and go, pieces without cells, cycles that come again, zeros without a sign.
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>
#include <optional>

#include "coupled.h"

namespace {

/// Blocks of 2^3 unit cells side by side along x, with q = the cell's number on cells and a
/// velocity of (1, 0, 0) on vertices.
struct Blocks {
  explicit Blocks(const std::string& scene, const std::string& output) {
    insitu::Options options;
    options.scene_text = scene;
    options.output = output;
    options.log = [this](insitu::LogLevel level, const char* message) {
      if (level <= insitu::LogLevel::warning)
        log.emplace_back(message);
    };
    session.emplace(options);
    mesh.emplace(session->mesh("m"));
    for (std::size_t c = 0; c < q.size(); ++c)
      q[c] = double(c);
  }
  void give(int pieces) {
    for (int p = 0; p < pieces; ++p) {
      insitu::Piece piece = mesh->piece(p);
      piece.uniform_block({3, 3, 3}, {2.0 * p, 0, 0}, {1, 1, 1});
      piece.cell_field("q", insitu::Array(q.data(), 8));
      piece.vertex_field("v", insitu::Array(v.data(), 27).components(3));
    }
    mesh->drop_pieces(pieces);
  }

  std::vector<double> q = std::vector<double>(8);
  std::vector<double> v = [] {
    std::vector<double> out(81);
    for (std::size_t i = 0; i < 81; i += 3)
      out[i] = 1;
    return out;
  }();
  std::vector<std::string> log;
  std::optional<insitu::Session> session;
  std::optional<insitu::Mesh> mesh;
};

const char* const scene = R"(insitu: 1
page: false
probes:
  - {name: p, points: [[1.5, 0.5, 0.5], [2.5, 0.5, 0.5]], fields: [q], output: [csv, netcdf]}
tracers:
  - {name: t, velocity: v, seeds: [[1.25, 0.5, 0.5]], output: [csv, netcdf]}
)";

TEST(Pieces, ThatComeLeaveTheColumnsOfATable) {
  const test::Folder folder;
  Blocks run(scene, folder.path());
  run.give(1);
  ASSERT_TRUE(run.session->execute(0, 0.0)) << insitu_last_message();
  run.give(2);
  ASSERT_TRUE(run.session->execute(1, 1.0)) << insitu_last_message();
  ASSERT_TRUE(run.session->execute(2, 1.25)) << insitu_last_message();
  EXPECT_EQ(run.log.size(), 4u) << "once a table";
  for (const std::string& said : run.log)
    EXPECT_NE(said.find("names no pieces"), std::string::npos) << said;
  run.session->close();
  const runs::Table p = runs::parse_table(test::content(folder / "p.csv"));
  ASSERT_EQ(p.rows.size(), 6u);
  EXPECT_EQ(p.text(0, "cell"), "1");
  EXPECT_EQ(p.text(1, "cell"), "-1");
  EXPECT_EQ(p.text(2, "cell"), "1");
  EXPECT_EQ(p.text(3, "cell"), "8"); // the second piece's first cell, counted through both
  EXPECT_EQ(p.number(3, "q"), 0);
  const runs::Table t = runs::parse_table(test::content(folder / "t.csv"));
  EXPECT_EQ(t.text(1, "cell"), "8");
  EXPECT_EQ(t.number(1, "x"), 2.25);
}

TEST(Pieces, ThatGoLeaveTheColumnsOfATable) {
  const test::Folder folder;
  Blocks run(scene, folder.path());
  run.give(2);
  ASSERT_TRUE(run.session->execute(0, 0.0)) << insitu_last_message();
  run.give(1);
  ASSERT_TRUE(run.session->execute(1, 0.25)) << insitu_last_message();
  EXPECT_TRUE(run.log.empty());
  run.session->close();
  const runs::Table p = runs::parse_table(test::content(folder / "p.csv"));
  EXPECT_EQ(p.text(1, "piece"), "1");
  EXPECT_EQ(p.text(2, "piece"), "0");
  EXPECT_EQ(p.text(3, "piece"), "-1");
}

// Blocks of one layer of vertices, of none, lists of no cells, with and without fields, beside one
// with cells; by every locator.
TEST(Pieces, WithoutCellsAddNothingByAnyLocator) {
  for (const insitu::Method method :
       {insitu::Method::bvh, insitu::Method::user_geometry, insitu::Method::replicated_faces,
        insitu::Method::shared_faces, insitu::Method::shared_bilinear_faces})
    for (const bool full : {true, false}) {
      SCOPED_TRACE(int(method));
      const test::Folder folder;
      Blocks run(std::string(scene) + "frames:\n  - {name: f, size: [16, 16], volume: {field: q}}\n"
                                      "  - {name: g, size: [16, 16], isosurfaces: [{field: q, "
                                      "values: [3.5]}], boundary: {}}\n",
                 folder.path());
      run.mesh->locator(method);
      run.mesh->piece(0).uniform_block({3, 3, 1}, {0, 0, 0}, {1, 1, 0});
      run.mesh->piece(1).uniform_block({0, 0, 0}, {0, 0, 0}, {0, 0, 0});
      run.mesh->piece(2).block(1, 5, 5);
      run.mesh->piece(3).cells(insitu::Shape::hexahedron, static_cast<const std::int64_t*>(nullptr),
                               0);
      run.mesh->piece(0).cell_field("q", insitu::Array(run.q.data(), 0));
      if (full) {
        insitu::Piece piece = run.mesh->piece(4);
        piece.uniform_block({3, 3, 3}, {0, 0, 0}, {1, 1, 1});
        piece.cell_field("q", insitu::Array(run.q.data(), 8));
        piece.vertex_field("v", insitu::Array(run.v.data(), 27).components(3));
      }
      for (int cycle = 0; cycle < 3; ++cycle) {
        run.mesh->changed(cycle == 1 ? insitu::everything : insitu::fields);
        EXPECT_TRUE(run.session->execute(cycle, 0.1 * cycle)) << insitu_last_message();
      }
      const insitu::Report report = run.session->report();
      EXPECT_EQ(report.failures, 0);
      EXPECT_EQ(report.frames, full ? 6 : 0);
      run.session->close();
      if (!full)
        continue;
      const runs::Table p = runs::parse_table(test::content(folder / "p.csv"));
      EXPECT_EQ(p.text(0, "piece"), "4");
      EXPECT_EQ(p.text(0, "cell"), "1");
      EXPECT_EQ(p.text(1, "piece"), "-1");
    }
}

TEST(Cycles, ThatComeAgainAreTold) {
  const test::Folder folder;
  Blocks run(scene, folder.path());
  run.give(1);
  for (const int cycle : {5, 4, 3, 2})
    ASSERT_TRUE(run.session->execute(cycle, -0.01 * cycle)) << insitu_last_message();
  EXPECT_TRUE(run.log.empty()) << "a run may count down";
  for (int i = 0; i < 2; ++i)
    ASSERT_TRUE(run.session->execute(2, 0.0)) << insitu_last_message();
  ASSERT_EQ(run.log.size(), 1u) << "once";
  EXPECT_NE(run.log[0].find("cycle 2 follows cycle 2"), std::string::npos) << run.log[0];
}

TEST(Zeros, OfTimesAndPlacesHaveNoSign) {
  const test::Folder folder;
  Blocks run(
      "insitu: 1\nprobes:\n  - {name: p, points: [[0.5, 0.5, -0.0]], fields: [q], output: "
      "[csv, json], attached: body}\ntracers:\n"
      "  - {name: t, direction: backward, velocity: v, seeds: [[0.5, -0.0, 0.5]]}\n"
      "  - {name: s, kind: streamline, direction: backward, velocity: v, seeds: [[0.5, -0.0, "
      "0.5]]}\n"
      "frames:\n  - {name: f, size: [16, 16], volume: {field: q}}\n",
      folder.path());
  run.give(1);
  for (const double time : {0.25, -0.0})
    ASSERT_TRUE(run.session->execute(time > 0 ? 0 : 1, time)) << insitu_last_message();
  run.session->close();
  const std::vector<std::string> places = {"-0,", ",-0\n", "-0.0,", "-0]", "-0}", "\"-0\""};
  for (const auto& [name, text] : runs::files_of(folder.path())) {
    if (name.find(".png") != std::string::npos || name.find(".html") != std::string::npos)
      continue;
    for (const std::string& place : places)
      EXPECT_EQ(text.find(place), std::string::npos) << name << "\n" << text.substr(0, 2000);
  }
}

} // namespace
