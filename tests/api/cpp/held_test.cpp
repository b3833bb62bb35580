// Steps held beside the live one: queries of them, the ring, what is refused, memory.
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "insitu/insitu.hpp"

#include "fixtures/hexahedra.h"

namespace {

/// A solver of a lattice of n^3 cubes, which may bend, with a field that changes.
struct Solver {
  explicit Solver(int cells) : n(cells), ids(insitu::fixtures::lattice_hexahedra(cells)) {
    set(0.0, 0.0);
  }
  void set(double time, double bend) {
    xyz.clear();
    p.clear();
    for (int k = 0; k <= n; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
          const double x = double(i) / n, y = double(j) / n, z = double(k) / n;
          xyz.insert(xyz.end(), {x + bend * y * z, y, z + bend * x});
          p.push_back(std::sin(3.0 * x + time) + y * z);
        }
  }
  void give(insitu::Mesh mesh) {
    mesh.points(xyz.data(), xyz.size() / 3);
    mesh.hexahedra(ids.data(), ids.size() / 8);
    mesh.vertex_field("p", p.data());
  }
  int n;
  std::vector<std::int64_t> ids;
  std::vector<double> xyz, p;
};

/// What queries answer.
struct Answers {
  std::vector<std::int64_t> cells, near;
  std::vector<std::uint8_t> reasons;
  std::vector<double> places, values, distances;
  bool operator==(const Answers& b) const {
    const auto same = [](const std::vector<double>& x, const std::vector<double>& y) {
      return x.size() == y.size() &&
             std::equal(x.begin(), x.end(), y.begin(),
                        [](double u, double v) { return u == v || (u != u && v != v); });
    };
    return cells == b.cells && near == b.near && reasons == b.reasons && same(places, b.places) &&
           same(values, b.values) && same(distances, b.distances);
  }
};

Answers ask(insitu::Mesh mesh, insitu_accuracy accuracy) {
  std::vector<double> points;
  for (int i = 0; i < 300; ++i) // some on vertices, some outside
    for (int a = 0; a < 3; ++a)
      points.push_back(i < 30 ? 0.25 * ((i >> a) & 3) : std::fmod((a + 1.3) * 0.318 * i, 1.2));
  const std::size_t n = points.size() / 3;
  Answers out;
  out.cells.resize(n);
  out.reasons.resize(n);
  out.places.resize(3 * n);
  out.values.resize(n);
  const insitu_array at = insitu_array_of(points.data(), INSITU_FLOAT64, std::int64_t(n), 3);
  insitu_sample_args args = insitu_sample_args_default();
  args.locate.points = &at;
  args.locate.accuracy = accuracy;
  args.locate.cells = out.cells.data();
  args.locate.reasons = out.reasons.data();
  args.locate.parametric = out.places.data();
  const char* const fields[] = {"p"};
  double* const values[] = {out.values.data()};
  args.fields = fields;
  args.values = values;
  args.field_count = 1;
  EXPECT_EQ(insitu_mesh_sample(mesh.handle(), &args), INSITU_OK) << insitu_last_message();
  out.near.resize(2 * n);
  out.distances.resize(2 * n);
  insitu_vertices_args near = insitu_vertices_args_default();
  near.points = &at;
  near.nearest = 2;
  near.vertices = out.near.data();
  near.distances = out.distances.data();
  EXPECT_EQ(insitu_mesh_nearest_vertices(mesh.handle(), &near), INSITU_OK) << insitu_last_message();
  return out;
}

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const insitu::Error& e) {
    return e.what();
  }
  return "no error";
}

std::int64_t bytes_held(const insitu::Session& session) {
  return session.report().bytes_by_purpose[INSITU_MEMORY_HELD];
}

using Cycles = std::vector<std::int64_t>;

} // namespace

TEST(Held, QueriesAnswerAsTheStepDidWhenItWasLive) {
  for (const insitu_accuracy accuracy : {INSITU_FAST, INSITU_EXACT})
    for (const double bend : {0.0, 0.05}) { // 0: the mesh stands
      Solver solver(5);
      insitu::Session session;
      insitu::Mesh mesh = session.mesh("m");
      session.hold(3);
      solver.give(mesh);
      std::vector<Answers> live;
      for (int cycle = 0; cycle < 5; ++cycle) {
        solver.set(cycle, bend * cycle);
        mesh.changed(bend > 0.0 ? insitu::geometry | insitu::fields : insitu::fields);
        session.execute(cycle, cycle);
        live.push_back(ask(mesh, accuracy));
      }
      EXPECT_EQ(session.held(), (Cycles{2, 3, 4}));
      solver.set(99.0, 0.3); // which nobody told
      const auto builds = session.report().rebuilds;
      EXPECT_EQ(builds, 1); // the live mesh's first: held steps have copies of its tree
      for (const std::int64_t cycle : {2, 4, 3, 2}) {
        session.show(cycle);
        EXPECT_TRUE(ask(mesh, accuracy) == live[std::size_t(cycle)]) << cycle;
        double value = 0.0;
        const double middle[] = {0.41, 0.52, 0.63};
        EXPECT_EQ(insitu_mesh_sample_point(mesh.handle(), "p", middle, &value, nullptr), INSITU_OK);
      }
      EXPECT_EQ(session.report().rebuilds, builds);
      session.show_live();
      solver.set(5.0, 0.0);
      mesh.changed(insitu::geometry | insitu::fields);
      session.execute(5, 5.0);
      EXPECT_EQ(session.held(), (Cycles{3, 4, 5}));
      EXPECT_FALSE(ask(mesh, accuracy) == live[4]);
    }
}

TEST(Held, TheSolverGoesOnWhileAStepIsShown) {
  Solver solver(4);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  session.hold(2);
  solver.give(mesh);
  session.execute(7, 0.7);
  const Answers before = ask(mesh, INSITU_EXACT);
  session.show(7);
  Solver other(6); // it regrids, and commits
  other.set(1.0, 0.1);
  other.give(mesh);
  mesh.commit();
  EXPECT_TRUE(ask(mesh, INSITU_EXACT) == before);
  session.show_live();
  EXPECT_FALSE(ask(mesh, INSITU_EXACT) == before);
  session.execute(8, 0.8);
  EXPECT_EQ(session.held(), (Cycles{7, 8}));
  session.show(7);
  EXPECT_TRUE(ask(mesh, INSITU_EXACT) == before);
}

TEST(Held, ARingOfTheLastStepsByTheirCycles) {
  Solver solver(3);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  solver.give(mesh);
  session.execute(1, 0.1);
  EXPECT_EQ(session.held(), Cycles{}); // nothing was asked for
  session.hold(3);
  for (const std::int64_t cycle : {1, 2, 3, 2}) // 2 comes again
    session.execute(cycle, double(cycle));
  EXPECT_EQ(session.held(), (Cycles{1, 3, 2}));
  session.execute(4, 4.0);
  EXPECT_EQ(session.held(), (Cycles{3, 2, 4}));
  session.hold(1);
  EXPECT_EQ(session.held(), Cycles{4});
  EXPECT_GT(bytes_held(session), 0);
  session.hold(0);
  EXPECT_EQ(session.held(), Cycles{});
  EXPECT_EQ(bytes_held(session), 0);
  std::int32_t room = 0;
  EXPECT_EQ(insitu_session_held(session.handle(), nullptr, &room), INSITU_OK);
  EXPECT_EQ(room, 0);
}

/// Of a mesh that stands a step takes its fields alone.
TEST(Held, AMeshThatStandsIsCopiedOnce) {
  Solver solver(8);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  solver.give(mesh);
  session.hold(4);
  session.execute(0, 0.0);
  const std::int64_t one = bytes_held(session), tree = session.report().bytes_by_purpose[0];
  for (int cycle = 1; cycle < 4; ++cycle) {
    solver.set(cycle, 0.0);
    mesh.changed(insitu::fields);
    session.execute(cycle, cycle);
  }
  const auto field = std::int64_t(solver.p.size() * sizeof(double));
  EXPECT_EQ(bytes_held(session), one + 3 * field);
  EXPECT_EQ(session.report().bytes_by_purpose[INSITU_MEMORY_TREE], tree);
  mesh.changed(insitu::geometry);
  session.execute(4, 4.0);
  EXPECT_EQ(bytes_held(session), 2 * one + 2 * field);
}

TEST(Held, WhatIsRefusedIsNamed) {
  Solver solver(3);
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("m");
  solver.give(mesh);
  EXPECT_EQ(message_of([&] { session.show(3); }), "cycle 3 is not held; none is");
  session.hold(2);
  session.execute(10, 1.0);
  session.execute(20, 2.0);
  EXPECT_EQ(message_of([&] { session.show(30); }), "cycle 30 is not held; those held are 10 20");
  EXPECT_NE(message_of([&] { session.hold(-1); }).find("steps: -1"), std::string::npos);
  session.show(10);
  EXPECT_NE(message_of([&] { session.show(30); }).find("not held"), std::string::npos);
  EXPECT_NE(message_of([&] { session.hold(1); }).find("cycle 10 is shown"), std::string::npos);
  insitu::Mesh later = session.mesh("later");
  EXPECT_NE(message_of([&] {
              (void)later.sample("p", std::vector<std::array<double, 3>>{});
            }).find("mesh 'later' was not there in cycle 10"),
            std::string::npos);
  EXPECT_EQ(insitu_session_execute(session.handle(), INSITU_LIVE, 1.0), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(insitu_session_held(session.handle(), nullptr, nullptr), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(insitu_session_show(nullptr, 10), INSITU_ERROR_HANDLE);
  EXPECT_EQ(session.held(), (Cycles{10, 20}));
  (void)ask(mesh, INSITU_EXACT); // of cycle 10, which is still shown
}

TEST(Held, TracersGoOnWithLiveSteps) {
  const std::string out = testing::TempDir() + "insitu_held_tracers";
  Solver solver(4);
  std::vector<double> u(solver.xyz.size(), 0.01);
  std::string log;
  insitu::Options options;
  options.scene_text = "insitu: 1\npage: false\nhold: {steps: 2}\n"
                       "probes: [{name: g, points: [[0.5, 0.5, 0.5]]}]\n"
                       "tracers: [{name: drifters, velocity: u, seeds: [[0.5, 0.5, 0.5]]}]\n";
  options.output = out;
  options.log = [&](insitu::LogLevel, const char* message) { log += message; };
  insitu::Session session(options);
  insitu::Mesh mesh = session.mesh("m");
  solver.give(mesh);
  mesh.vertex_field("u", insitu::Array(u.data(), u.size() / 3).components(3));
  for (int cycle = 0; cycle < 3; ++cycle)
    EXPECT_TRUE(session.execute(cycle, cycle));
  EXPECT_EQ(session.held(), (Cycles{1, 2}));
  const insitu::Report before = session.report();
  session.show(1);
  EXPECT_TRUE(session.execute(101, 1.0));
  EXPECT_TRUE(session.execute(102, 1.0));
  session.show_live();
  EXPECT_EQ(session.report().probe_rows, before.probe_rows + 2);
  EXPECT_EQ(session.held(), (Cycles{1, 2}));
  const std::string told = "tracer 'drifters' goes on with live steps alone";
  EXPECT_NE(log.find(told), std::string::npos) << log;
  EXPECT_EQ(log.find(told), log.rfind(told));
  EXPECT_TRUE(session.execute(3, 3.0));
  EXPECT_EQ(session.report().particles[INSITU_END_ALIVE], 1);
}
