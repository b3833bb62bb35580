// Why particles end where they go no further: at the mesh's end, before a gap, a hidden cell,
// another process's cell, and where the velocity has no values. A uniform flow in the unit cube,
// whose wall is at x = 5/8, whatever the cells.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <memory>

#include "coupled.h"
#include "cubes.h"
#include "numerics/exact/cases.h"

namespace {

using insitu::test::MeshKind;
using runs::Point;
using runs::Table;

constexpr int n = 8;                                ///< cells along an edge of the cube
constexpr double wall = 5.0 / n, blank_from = 0.75; ///< vertices from there on are blank
constexpr double fill = 1e20;

/// A cube of one kind of cells whose vertices are not shifted.
struct Solver {
  explicit Solver(MeshKind kind) {
    insitu::test::TestMesh made =
        insitu::test::make_mesh({.kind = kind, .size = n, .jitter = 0.0}, 1);
    for (auto& p : made.vertices)
      p = p / double(n);
    arrays.emplace(made);
    for (std::size_t v = 0; v < arrays->mesh.points.size(); v += 3) {
      velocity.insert(velocity.end(), {0.25, 0, 0});
      salt.push_back(float(arrays->mesh.points[v + 1]));
      hidden.push_back(0);
    }
    for (std::size_t c = 0; c < arrays->mesh.types.size(); ++c)
      ghosts.push_back(0);
  }
  double x(std::size_t vertex) const { return arrays->mesh.points[3 * vertex]; }
  double middle(std::size_t cell) const {
    const auto first = std::size_t(arrays->mesh.offsets[cell]);
    const auto end = std::size_t(arrays->mesh.offsets[cell + 1]);
    double low = 1, high = 0;
    for (std::size_t v = first; v < end; ++v) {
      low = std::min(low, x(std::size_t(arrays->mesh.ids[v])));
      high = std::max(high, x(std::size_t(arrays->mesh.ids[v])));
    }
    return 0.5 * (low + high);
  }
  template <class To>
  void give(To& mesh) {
    mesh.points(insitu::Array(arrays->mesh.points).components(3));
    mesh.mixed_cells(arrays->mesh.types, arrays->mesh.offsets, arrays->mesh.ids);
    mesh.vertex_field("velocity", insitu::Array(velocity).components(3));
    mesh.vertex_field("salt", salt);
  }

  std::optional<runs::Arrays> arrays;
  std::vector<double> velocity;
  std::vector<float> salt;
  std::vector<std::uint8_t> hidden, ghosts;
};

using Prepare = std::function<void(Solver&, insitu::Mesh&)>;

constexpr const char* scene = R"(
insitu: 1
page: false
every: 1
tracers:
  - {name: plain, velocity: velocity, fields: [salt], seeds: [[0.3, 0.31, 0.33], [0.3, 0.5, 0.5], [0.9, 0.4, 0.4]]}
  - {name: fixed, velocity: velocity, integrator: {method: rk4, step: 0.07}, seeds: [[0.3, 0.31, 0.33]]}
  - {name: lines, kind: streamline, every: 4, velocity: velocity, seeds: [[0.3, 0.31, 0.33]]}
  - {name: stops, velocity: velocity, seeds: [[0.3, 0.31, 0.33]], effects: [{boundary: stop}]}
  - {name: slides, velocity: velocity, seeds: [[0.3, 0.31, 0.33]], effects: [{boundary: slide}, {settling: {speed: 0.1}}]}
  - {name: back, velocity: velocity, seeds: [[0.3, 0.31, 0.33]], effects: [{boundary: put_back}]}
)";

runs::Files run(MeshKind kind, const Prepare& prepare) {
  const test::Folder folder;
  insitu::Options options;
  options.scene_text = scene;
  options.output = folder.path();
  options.threads = 2;
  options.log_level = insitu::LogLevel::error;
  {
    insitu::Session session(options);
    insitu::Mesh mesh = session.mesh("cube");
    Solver solver(kind);
    solver.give(mesh);
    prepare(solver, mesh);
    for (int cycle = 0; cycle <= 4; ++cycle) {
      mesh.changed(insitu::fields);
      EXPECT_TRUE(session.execute(cycle, 0.5 * cycle)) << insitu_last_message();
    }
  }
  return runs::files_of(folder.path());
}

/// The last row of a particle.
std::size_t last_of(const Table& t, int particle, const char* column = "particle") {
  std::size_t last = t.rows.size();
  for (std::size_t i = 0; i < t.rows.size(); ++i)
    if (int(t.number(i, column)) == particle)
      last = i;
  EXPECT_LT(last, t.rows.size());
  return std::min(last, t.rows.size() - 1);
}

/// ending: of those that go through the wall; seeded: of those that begin beyond it. What is beyond
/// is a wall to all effects.
void expect_wall(const runs::Files& files, const std::string& ending, const std::string& seeded,
                 double at = wall) {
  const auto expect_end = [&](const Table& t, std::size_t row, const std::string& want) {
    EXPECT_EQ(t.text(row, "ending"), want);
    EXPECT_NEAR(t.number(row, "x"), at, 1e-9); // straight to the face
    EXPECT_LE(t.number(row, "x"), at);
  };
  const Table plain = runs::parse_table(files.at("plain.csv"));
  for (const int particle : {0, 1}) {
    expect_end(plain, last_of(plain, particle), ending);
    EXPECT_TRUE(std::isfinite(plain.number(last_of(plain, particle), "salt")));
  }
  EXPECT_EQ(plain.text(last_of(plain, 2), "ending"), seeded);
  const Table fixed = runs::parse_table(files.at("fixed.csv"));
  expect_end(fixed, last_of(fixed, 0), ending);
  const Table lines = runs::parse_table(files.at("lines_000004.csv"));
  expect_end(lines, last_of(lines, 0, "line"), ending);
  const Table stops = runs::parse_table(files.at("stops.csv"));
  expect_end(stops, last_of(stops, 0), "stopped");
  const Table slides = runs::parse_table(files.at("slides.csv"));
  EXPECT_NEAR(slides.number(last_of(slides, 0), "x"), at, 1e-6);
  EXPECT_NEAR(slides.number(last_of(slides, 0), "z"), 0.33 - 0.2, 1e-6);
  const Table back = runs::parse_table(files.at("back.csv"));
  EXPECT_EQ(back.text(last_of(back, 0), "ending"), "killed");
  EXPECT_LT(back.number(last_of(back, 0), "x"), at);
}

class Endings : public testing::TestWithParam<MeshKind> {};

TEST_P(Endings, BlankVerticesAreAWall) {
  expect_wall(run(GetParam(),
                  [](Solver& s, insitu::Mesh& mesh) {
                    for (std::size_t v = 0; v < s.hidden.size(); ++v)
                      if (s.x(v) >= blank_from - 1e-9)
                        s.velocity[3 * v + v % 3] = fill; // of one component
                    mesh.field_blank("velocity", fill);
                  }),
              "blank", "blank");
}

TEST_P(Endings, NaNMayBeTheBlankValue) {
  expect_wall(run(GetParam(),
                  [](Solver& s, insitu::Mesh& mesh) {
                    for (std::size_t v = 0; v < s.hidden.size(); ++v)
                      if (s.x(v) >= blank_from - 1e-9)
                        s.velocity[3 * v] = std::numeric_limits<double>::quiet_NaN();
                    mesh.field_blank("velocity", std::numeric_limits<double>::quiet_NaN());
                  }),
              "blank", "blank");
}

TEST_P(Endings, HiddenPointsAreBlankInAllFieldsOfVertices) {
  expect_wall(run(GetParam(),
                  [](Solver& s, insitu::Mesh& mesh) {
                    for (std::size_t v = 0; v < s.hidden.size(); ++v)
                      s.hidden[v] = s.x(v) >= blank_from - 1e-9 ? 2 : 1; // 1: a duplicate
                    mesh.hidden_points(s.hidden);
                  }),
              "blank", "blank");
}

TEST_P(Endings, HiddenCellsAndGhostsAreToldApart) {
  const auto with = [](std::uint8_t bits) {
    return [bits](Solver& s, insitu::Mesh& mesh) {
      for (std::size_t c = 0; c < s.ghosts.size(); ++c)
        s.ghosts[c] = s.middle(c) > wall ? bits : 0;
      mesh.ghosts(s.ghosts);
    };
  };
  expect_wall(run(GetParam(), with(32)), "hidden", "hidden");
  expect_wall(run(GetParam(), with(8)), "hidden", "hidden");
  expect_wall(run(GetParam(), with(1)), "partition", "partition");
  expect_wall(run(GetParam(), with(1 | 32)), "hidden", "hidden");
}

TEST_P(Endings, GarbageInGhostsIsNotRead) {
  expect_wall(run(GetParam(),
                  [](Solver& s, insitu::Mesh& mesh) {
                    for (std::size_t c = 0; c < s.ghosts.size(); ++c)
                      if (s.middle(c) > wall) {
                        s.ghosts[c] = 1;
                        for (auto v = s.arrays->mesh.offsets[c]; v < s.arrays->mesh.offsets[c + 1];
                             ++v)
                          s.arrays->mesh.ids[std::size_t(v)] = -7 - std::int32_t(v);
                      }
                    mesh.ghosts(s.ghosts);
                  }),
              "left", "seed_outside");
}

TEST_P(Endings, AGapIsAHoleAndTheEndIsNot) {
  // Cells between 5/8 and 7/8 are not there.
  const auto files = run(GetParam(), [](Solver& s, insitu::Mesh& mesh) {
    auto& m = s.arrays->mesh;
    decltype(m.ids) ids;
    decltype(m.types) types;
    decltype(m.offsets) offsets{0};
    for (std::size_t c = 0; c < m.types.size(); ++c) {
      if (s.middle(c) > wall && s.middle(c) < 7.0 / n)
        continue;
      types.push_back(m.types[c]);
      ids.insert(ids.end(), m.ids.begin() + m.offsets[c], m.ids.begin() + m.offsets[c + 1]);
      offsets.push_back(decltype(offsets)::value_type(ids.size()));
    }
    m.ids = ids;
    m.types = types;
    m.offsets = offsets;
    s.give(mesh);
  });
  const Table plain = runs::parse_table(files.at("plain.csv"));
  EXPECT_EQ(plain.text(last_of(plain, 0), "ending"), "hole");
  EXPECT_NEAR(plain.number(last_of(plain, 0), "x"), wall, 1e-9);
  EXPECT_EQ(plain.text(last_of(plain, 2), "ending"), "left"); // at x = 1
  EXPECT_NEAR(plain.number(last_of(plain, 2), "x"), 1.0, 1e-9);
}

std::string name_of(const testing::TestParamInfo<MeshKind>& info) {
  switch (info.param) {
  case MeshKind::hexahedra:
    return "Hexahedra";
  case MeshKind::wedges:
    return "Wedges";
  case MeshKind::voxels:
    return "Voxels";
  default:
    return "Tetrahedra";
  }
}

// In pyramids and mixed cells no plane of faces stands at the wall.
INSTANTIATE_TEST_SUITE_P(Kinds, Endings,
                         testing::Values(MeshKind::hexahedra, MeshKind::wedges, MeshKind::voxels,
                                         MeshKind::tetrahedra),
                         name_of);

TEST(Blanks, CellsOwnPointsAndSamplesAreNaN) {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("cube");
  Solver s(MeshKind::hexahedra);
  s.give(mesh);
  for (std::size_t v = 0; v < s.salt.size(); ++v)
    if (s.x(v) >= blank_from - 1e-9)
      s.salt[v] = float(fill);
  mesh.field_blank("salt", fill); // as float has it
  mesh.commit();
  const std::vector<double> points{0.3, 0.4,  0.5, 0.7,  0.4,        0.5, 0.9, 0.4,
                                   0.5, wall, 0.4, 0.55, blank_from, 0.4, 0.55};
  const auto at = mesh.locate(points);
  for (const std::int64_t cell : at.cells)
    EXPECT_GE(cell, 0);
  const std::vector<double> salt = mesh.sample("salt", points).values;
  EXPECT_NEAR(salt[0], 0.4, 1e-6);
  EXPECT_TRUE(std::isnan(salt[1]));
  EXPECT_TRUE(std::isnan(salt[2]));
  EXPECT_NEAR(salt[3], 0.4, 1e-6); // on a face without blank vertices, whoever owns it
  EXPECT_TRUE(std::isnan(salt[4]));
  const std::vector<double> u = mesh.sample("velocity", points).values;
  EXPECT_EQ(u[3], 0.25); // other fields are there
  bool copied = false;
  for (const insitu_audit_entry& e : mesh.audit())
    copied |= !e.borrowed && std::string(e.name).find("salt") != std::string::npos;
  EXPECT_TRUE(copied);
}

TEST(Blanks, WhatCannotBeIsRefusedByName) {
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("cube");
  Solver s(MeshKind::voxels);
  s.give(mesh);
  EXPECT_THROW(mesh.field_blank("salty", 1), insitu::Error);
  EXPECT_NE(std::string(insitu_last_message()).find("salt"), std::string::npos);
  s.hidden.pop_back();
  mesh.hidden_points(insitu::Array(s.hidden));
  EXPECT_THROW(mesh.commit(), insitu::Error);
  EXPECT_NE(std::string(insitu_last_message()).find("728"), std::string::npos)
      << insitu_last_message();
  insitu::Mesh amr = session.mesh("amr");
  insitu::AmrLevels levels;
  levels.count = 1;
  levels.spacing = {1, 1, 1};
  amr.adaptive(levels);
  std::vector<double> values(8, 1.0);
  amr.piece(0).patch(0, {0, 0, 0}, {2, 2, 2});
  amr.piece(0).cell_field("p", values);
  EXPECT_THROW(amr.field_blank("p", 1), insitu::Error);
}

TEST(Blanks, StrictSessionsRefuseTheCopy) {
  insitu::Options options;
  options.strict = true;
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("cube");
  Solver s(MeshKind::voxels);
  s.give(mesh);
  mesh.field_blank("salt", std::numeric_limits<double>::quiet_NaN()); // needs none
  mesh.commit();
  mesh.field_blank("salt", fill);
  EXPECT_THROW(mesh.commit(), insitu::Error);
  EXPECT_NE(std::string(insitu_last_message()).find("salt"), std::string::npos);
}

/// Land that comes and goes: a particle ends where it is when its cell falls dry.
TEST(Blanks, CellsFallDry) {
  const test::Folder folder;
  insitu::Options options;
  options.scene_text = "insitu: 1\npage: false\ntracers:\n  - {name: t, velocity: velocity, seeds: "
                       "[[0.3, 0.31, 0.33], [0.05, 0.5, 0.5]]}\n";
  options.output = folder.path();
  {
    insitu::Session session(options);
    insitu::Mesh mesh = session.mesh("cube");
    Solver s(MeshKind::hexahedra);
    s.give(mesh);
    mesh.field_blank("velocity", fill);
    for (int cycle = 0; cycle <= 4; ++cycle) {
      // From cycle 2 on all is dry from x = 1/4.
      for (std::size_t v = 0; v < s.hidden.size(); ++v)
        s.velocity[3 * v] = s.x(v) >= (cycle < 2 ? 0.99 : 0.24) ? fill : 0.05;
      mesh.changed(insitu::fields);
      ASSERT_TRUE(session.execute(cycle, 0.5 * cycle)) << insitu_last_message();
    }
  }
  const Table t = runs::parse_table(test::content(folder / "t.csv"));
  EXPECT_EQ(t.text(last_of(t, 0), "ending"), "blank");
  EXPECT_NEAR(t.number(last_of(t, 0), "x"), 0.3 + 0.05 * 0.5, 1e-9);
  EXPECT_EQ(t.text(last_of(t, 1), "ending"), "blank"); // at the new shore, 1/8
  EXPECT_NEAR(t.number(last_of(t, 1), "x"), 0.125, 1e-9);
}

/// The velocity of cells, on a mesh whose vertices move, and with other cells at every step.
TEST(Blanks, OfCellsThatMoveOrBecomeOthers) {
  for (const bool others : {false, true}) {
    SCOPED_TRACE(others ? "other cells" : "moving cells");
    const test::Folder folder;
    insitu::Options options;
    options.scene_text = "insitu: 1\npage: false\ntracers:\n  - {name: t, velocity: velocity, "
                         "seeds: [[0.3, 0.31, 0.33]]}\n";
    options.output = folder.path();
    {
      insitu::Session session(options);
      insitu::Mesh mesh = session.mesh("cube");
      std::vector<std::unique_ptr<Solver>> solvers; // one, or one a step
      for (int cycle = 0; cycle <= 6; ++cycle) {
        if (cycle == 0 || others) {
          solvers.push_back(
              std::make_unique<Solver>(cycle % 2 ? MeshKind::wedges : MeshKind::hexahedra));
          Solver& s = *solvers.back();
          s.velocity.assign(3 * s.ghosts.size(), 0.0);
          for (std::size_t c = 0; c < s.ghosts.size(); ++c)
            s.velocity[3 * c] = s.middle(c) > wall ? fill : 0.25;
          mesh.points(insitu::Array(s.arrays->mesh.points).components(3));
          mesh.mixed_cells(s.arrays->mesh.types, s.arrays->mesh.offsets, s.arrays->mesh.ids);
          mesh.cell_field("velocity", insitu::Array(s.velocity).components(3));
          mesh.field_blank("velocity", fill);
        } else {
          // The whole cube goes on along x at a tenth of the flow.
          auto& points = solvers.back()->arrays->mesh.points;
          for (std::size_t v = 0; v < points.size(); v += 3)
            points[v] += 0.25 * 0.1 * 0.25;
          mesh.changed(insitu::geometry | insitu::fields);
        }
        ASSERT_TRUE(session.execute(cycle, 0.25 * cycle)) << insitu_last_message();
      }
    }
    const Table t = runs::parse_table(test::content(folder / "t.csv"));
    const std::size_t last = last_of(t, 0);
    EXPECT_EQ(t.text(last, "ending"), "blank");
    // 0.3 + 0.25 t = 0.625 (+ 0.025 t)
    const double time = (wall - 0.3) / (others ? 0.25 : 0.225);
    EXPECT_NEAR(t.number(last, "time"), time, 1e-6);
    EXPECT_NEAR(t.number(last, "x"), 0.3 + 0.25 * time, 1e-6);
  }
}

} // namespace
