// A host that knows Catalyst's interface alone: the loader loads libcatalyst-insitu.so by name, and
// a run gives the tables of one that is coupled by insitu.hpp.
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <sstream>

#include "insitu/insitu.hpp"

#include "nodes.h"

namespace {

namespace fs = std::filesystem;

const char* const scene = R"(insitu: 1
probes:
  - name: gauges
    mesh: grid
    every: 1
    points: [[1.1, 2.1, 3.1], [2.5, 2.9, 3.3], [4.9, 3.4, 3.4], [9, 9, 9]]
    fields: [f, number]
tracers:
  - name: drifters
    mesh: grid
    velocity: v
    seeds: {line: {from: [1.2, 2.2, 3.1], to: [1.2, 3.3, 3.4], count: 5}}
)";

std::string text_of(const fs::path& file) {
  std::ostringstream out;
  out << std::ifstream(file).rdbuf();
  return out.str();
}

/// A solver's step: the box, moved and with other values.
struct Solver {
  Box box;
  std::vector<double> u, v, w;
  Solver() {
    for (std::size_t i = 0; i < box.x.size(); ++i) {
      u.push_back(0.3 + 0.01 * box.y[i]);
      v.push_back(0.02 * box.x[i]);
      w.push_back(-0.001);
    }
  }
  void step(int cycle) {
    for (double& f : box.f)
      f += 0.125 * cycle;
    for (double& z : box.z)
      z += 1.0 / 1024;
  }
};

class Catalyst : public testing::Test {
protected:
  Catalyst() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(folder_ / "scene.yaml") << scene;
    setenv("CATALYST_IMPLEMENTATION_NAME", "insitu", 1);
    setenv("CATALYST_IMPLEMENTATION_PATHS", INSITU_CATALYST_FOLDER, 1);
    unsetenv("INSITU_SCENE");
  }
  ~Catalyst() override { catalyst_finalize(TestNode().set("catalyst/done", 1).get()); }

  TestNode start() const {
    TestNode node;
    node.set("catalyst/scripts/pipeline/filename", "/some/where/pipeline.py"); // ParaView's
    node.set("catalyst/scripts/scene/filename", (folder_ / "scene.yaml").string());
    node.set("catalyst/insitu/output", (folder_ / "catalyst").string());
    node.set("catalyst/insitu/strict", 1).set("catalyst/insitu/threads", 2);
    return node;
  }
  static TestNode step_of(Solver& solver, int cycle) {
    TestNode node;
    Box& b = solver.box;
    const std::string c = "catalyst/channels/grid/", d = c + "data/";
    node.set("catalyst/state/timestep", cycle).set("catalyst/state/time", 0.25 * cycle);
    node.set(c + "type", "mesh").set(d + "coordsets/coords/type", "explicit");
    node.set(d + "coordsets/coords/values/x", b.x).set(d + "coordsets/coords/values/y", b.y);
    node.set(d + "coordsets/coords/values/z", b.z);
    node.set(d + "topologies/topo/type", "unstructured")
        .set(d + "topologies/topo/coordset", "coords");
    node.set(d + "topologies/topo/elements/shape", "hex");
    node.set(d + "topologies/topo/elements/connectivity", b.hexahedra);
    node.set(d + "fields/f/association", "vertex").set(d + "fields/f/values", b.f);
    node.set(d + "fields/number/association", "element");
    node.set(d + "fields/number/values", b.number);
    node.set(d + "fields/v/association", "vertex").set(d + "fields/v/values/u", solver.u);
    node.set(d + "fields/v/values/v", solver.v).set(d + "fields/v/values/w", solver.w);
    return node;
  }
  /// The same run, coupled by the library's own interface. at_end: with f at the gauges.
  using AtEnd = std::function<void(insitu::Session&, const insitu::Samples&)>;
  void run_directly(int cycles, const AtEnd& at_end = {}) const {
    Solver solver;
    insitu::Options options;
    options.scene = (folder_ / "scene.yaml").string();
    options.output = (folder_ / "direct").string();
    options.threads = 2;
    insitu::Session session(options);
    insitu::Mesh mesh = session.mesh("grid");
    Box& b = solver.box;
    mesh.points(b.x, b.y, b.z);
    mesh.hexahedra(b.hexahedra.data(), b.own_cells());
    mesh.vertex_field("f", b.f);
    mesh.cell_field("number", b.number);
    mesh.vertex_field("v", {solver.u, solver.v, solver.w});
    session.keep_answers();
    for (int cycle = 0; cycle < cycles; ++cycle) {
      mesh.changed(insitu::geometry | insitu::fields);
      EXPECT_TRUE(session.execute(cycle, 0.25 * cycle));
      if (at_end && cycle == cycles - 1)
        at_end(session, mesh.sample("f", std::vector{1.1, 2.1, 3.1, 2.5, 2.9, 3.3, 4.9, 3.4, 3.4}));
      solver.step(cycle);
    }
    session.close();
  }

  fs::path folder_ =
      fs::temp_directory_path() / ("insitu_catalyst_" + std::to_string(getpid()) + INSITU_CONDUIT);
};

TEST_F(Catalyst, ARunGivesTheTablesOfADirectCoupling) {
  Solver solver;
  ASSERT_EQ(catalyst_initialize(start().get()), catalyst_status_ok);
  for (int cycle = 0; cycle < 5; ++cycle) {
    ASSERT_EQ(catalyst_execute(step_of(solver, cycle).get()), catalyst_status_ok);
    solver.step(cycle);
  }
  TestNode results, about;
  ASSERT_EQ(catalyst_results(results.get()), catalyst_status_ok);
  const auto count = [&](const char* name) {
    return conduit_node_as_int64(
        conduit_node_fetch(results.get(), (std::string("catalyst/insitu/") + name).c_str()));
  };
  EXPECT_EQ(count("cycle"), 4);
  EXPECT_EQ(count("executions"), 5);
  EXPECT_EQ(count("failures"), 0);
  EXPECT_EQ(count("particles_seeded"), 5);
  ASSERT_EQ(catalyst_about(about.get()), catalyst_status_ok);
  EXPECT_STREQ(
      conduit_node_as_char8_str(conduit_node_fetch(about.get(), "catalyst/implementation")),
      "insitu");
  ASSERT_EQ(catalyst_finalize(start().get()), catalyst_status_ok);

  run_directly(5);
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "direct")) {
    if (entry.path().extension() != ".csv")
      continue; // the page tells seconds
    const fs::path other = folder_ / "catalyst" / fs::relative(entry.path(), folder_ / "direct");
    EXPECT_EQ(text_of(entry.path()), text_of(other)) << other;
    ++files;
  }
  EXPECT_EQ(files, 2);
}

/// Values that a solver may steer by: those of a direct coupling's probe, to the bit.
TEST_F(Catalyst, ResultsHaveTheValuesOfProbes) {
  const std::string probe = "catalyst/insitu/probes/gauges/";
  Solver solver;
  ASSERT_EQ(catalyst_initialize(start().get()), catalyst_status_ok);
  TestNode before, results;
  ASSERT_EQ(catalyst_results(before.get()), catalyst_status_ok);
  EXPECT_FALSE(before.has("catalyst/insitu/probes")); // not due yet
  for (int cycle = 0; cycle < 3; ++cycle) {
    ASSERT_EQ(catalyst_execute(step_of(solver, cycle).get()), catalyst_status_ok);
    solver.step(cycle);
  }
  ASSERT_EQ(catalyst_results(results.get()), catalyst_status_ok);
  ASSERT_TRUE(results.has(probe + "cycle"));
  EXPECT_EQ(conduit_node_as_int64(conduit_node_fetch(results.get(), (probe + "cycle").c_str())), 2);
  EXPECT_EQ(results.doubles(probe + "time")[0], 0.5);
  EXPECT_EQ(results.doubles(probe + "points/x"), (std::vector{1.1, 2.5, 4.9, 9.0}));
  EXPECT_EQ(results.doubles(probe + "points/z"), (std::vector{3.1, 3.3, 3.4, 9.0}));
  EXPECT_EQ(results.bytes(probe + "inside"), (std::vector<std::uint8_t>{1, 1, 1, 0}));
  EXPECT_EQ(catalyst_finalize(start().get()), catalyst_status_ok);

  const std::vector<double> f = results.doubles(probe + "fields/f");
  ASSERT_EQ(f.size(), 4u);
  run_directly(3, [&](insitu::Session& session, const insitu::Samples& samples) {
    const std::vector<insitu::ProbeAnswers> answers = session.answers();
    ASSERT_EQ(answers.size(), 1u);
    ASSERT_EQ(answers[0].column_count, 2);
    EXPECT_STREQ(answers[0].column_names[0], "f");
    for (std::size_t p = 0; p < 4; ++p) {
      EXPECT_EQ(std::memcmp(&f[p], &answers[0].values[2 * p], 8), 0) << "point " << p;
      if (p < 3)
        EXPECT_EQ(f[p], samples(p));
      else
        EXPECT_TRUE(std::isnan(f[p]));
    }
  });
}

/// For solvers that do not steer the values stay where they are.
TEST_F(Catalyst, ResultsWithoutTheValuesOfProbes) {
  Solver solver;
  ASSERT_EQ(catalyst_initialize(start().set("catalyst/insitu/answers", 0).get()),
            catalyst_status_ok);
  ASSERT_EQ(catalyst_execute(step_of(solver, 0).get()), catalyst_status_ok);
  TestNode results;
  ASSERT_EQ(catalyst_results(results.get()), catalyst_status_ok);
  EXPECT_TRUE(results.has("catalyst/insitu/probe_rows"));
  EXPECT_FALSE(results.has("catalyst/insitu/probes"));
}

/// A channel that cannot be read, blocks as meshes, channels that go, and calls out of order.
TEST_F(Catalyst, ChannelsOfOtherKinds) {
  Solver solver;
  EXPECT_NE(catalyst_execute(step_of(solver, 0).get()), catalyst_status_ok); // not initialised
  ASSERT_EQ(catalyst_initialize(start().get()), catalyst_status_ok);
  EXPECT_NE(catalyst_initialize(start().get()), catalyst_status_ok);
  TestNode node = step_of(solver, 0);
  node.set("catalyst/channels/particles/type", "mesh");
  node.set("catalyst/channels/particles/data/coordsets/coords/type", "explicit");
  node.set("catalyst/channels/particles/data/topologies/p/type", "points");
  node.set("catalyst/channels/particles/data/topologies/p/coordset", "coords");
  node.set("catalyst/channels/other/type", "fides");
  EXPECT_EQ(catalyst_execute(node.get()), catalyst_status_ok);
  // The probe then has a mesh without cells, whose rows are NaN.
  TestNode empty;
  empty.set("catalyst/state/timestep", 1).set("catalyst/state/time", 0.25);
  catalyst_execute(empty.get());
  node = step_of(solver, 2);
  node.remove("catalyst/channels/grid/data/coordsets");
  EXPECT_NE(catalyst_execute(node.get()), catalyst_status_ok);
  EXPECT_EQ(catalyst_execute(step_of(solver, 3).get()), catalyst_status_ok);
  EXPECT_EQ(catalyst_finalize(node.get()), catalyst_status_ok);
}

/// A uniform block of n cells along each axis, whose cells have their numbers from `first` on.
struct Block {
  Block(TestNode& node, const std::string& path, int n, double origin, double spacing, double first)
      : numbers(std::size_t(n * n * n)) {
    for (std::size_t c = 0; c < numbers.size(); ++c)
      numbers[c] = first + double(c);
    for (const char* axis : {"x", "y", "z"}) {
      node.set(path + "coordsets/c/origin/" + axis, origin);
      node.set(path + "coordsets/c/spacing/d" + axis, spacing);
    }
    for (const char* axis : {"i", "j", "k"})
      node.set(path + "coordsets/c/dims/" + axis, n + 1);
    node.set(path + "coordsets/c/type", "uniform").set(path + "topologies/t/type", "uniform");
    node.set(path + "topologies/t/coordset", "c").set(path + "fields/n/association", "element");
    node.set(path + "fields/n/values", numbers);
  }
  std::vector<double> numbers;
};

TestNode cycle(int number) {
  TestNode node;
  node.set("catalyst/state/timestep", number).set("catalyst/state/time", 0.5 * number);
  return node;
}

/// The values of a field at a probe after the last call; empty if it has not answered.
std::vector<double> answers_of(const std::string& probe, const std::string& field = "n") {
  TestNode results;
  const std::string path = "catalyst/insitu/probes/" + probe + "/fields/" + field;
  return catalyst_results(results.get()) == catalyst_status_ok && results.has(path)
             ? results.doubles(path)
             : std::vector<double>();
}

/// Each block of a multimesh is a mesh of its own, named by the channel and the block.
TEST_F(Catalyst, BlocksOfAMultimeshAreMeshes) {
  std::ofstream(folder_ / "scene.yaml")
      << "insitu: 1\nprobes:\n"
         "  - {name: east, mesh: parts/east, points: [[0.5, 0.5, 0.5]], fields: [n]}\n"
         "  - {name: west, mesh: parts/west, points: [[0.5, 0.5, 0.5], [5.5, 5.5, 5.5]], "
         "fields: [n]}\n";
  ASSERT_EQ(catalyst_initialize(start().get()), catalyst_status_ok);
  const std::string parts = "catalyst/channels/parts/", data = parts + "data/";
  TestNode node = cycle(0);
  node.set(parts + "type", "multimesh");
  const Block east(node, data + "east/", 2, 0.0, 1.0, 10.0);
  const Block west(node, data + "west/", 2, 4.0, 1.0, 20.0);
  ASSERT_EQ(catalyst_execute(node.get()), catalyst_status_ok);
  EXPECT_EQ(answers_of("east"), std::vector{10.0});
  ASSERT_EQ(answers_of("west").size(), 2u);
  EXPECT_TRUE(std::isnan(answers_of("west")[0])); // the other block's
  EXPECT_EQ(answers_of("west")[1], 27.0);

  TestNode alone = cycle(1); // a block goes, and one of domains comes
  alone.set(parts + "type", "multimesh");
  const Block low(alone, data + "west/low/", 1, 0.0, 1.0, 30.0);
  const Block high(alone, data + "west/high/", 1, 5.0, 1.0, 40.0);
  EXPECT_EQ(catalyst_execute(alone.get()), catalyst_status_ok);
  EXPECT_EQ(answers_of("west"), (std::vector{30.0, 40.0}));
  alone.remove(data + "west/high/topologies/t/coordset");
  EXPECT_NE(catalyst_execute(alone.get()), catalyst_status_ok);
}

/// Of several topologies the first is the channel's mesh, and each further one that a field names
/// is a mesh, too; some domains may lack it, and a surface is none.
TEST_F(Catalyst, FurtherTopologiesAreMeshes) {
  std::ofstream(folder_ / "scene.yaml")
      << "insitu: 1\nprobes:\n"
         "  - {name: first, points: [[0.5, 0.5, 0.5], [4.5, 4.5, 4.5]], fields: [n]}\n"
         "  - {name: solid, mesh: grid/solid, points: [[1.25, 0.25, 0.25], [4.5, 0.5, 0.5]], "
         "fields: [heat]}\n";
  ASSERT_EQ(catalyst_initialize(start().get()), catalyst_status_ok);
  const std::string grid = "catalyst/channels/grid/", a = grid + "data/a/";
  TestNode node = cycle(0);
  node.set(grid + "type", "mesh");
  const Block left(node, a, 2, 0.0, 1.0, 10.0); // whose field names no topology
  const Block right(node, grid + "data/b/", 2, 4.0, 1.0, 20.0);
  std::vector<double> x{1, 3, 1, 1}, y{0, 0, 2, 0}, z{0, 0, 0, 2}, value{7};
  std::vector<std::int32_t> ids{0, 1, 2, 3};
  node.set(a + "coordsets/s/type", "explicit").set(a + "coordsets/s/values/x", x);
  node.set(a + "coordsets/s/values/y", y).set(a + "coordsets/s/values/z", z);
  for (const auto& [name, shape, field] :
       {std::array{"solid", "tet", "heat"}, {"wall", "quad", "flux"}, {"bare", "tet", ""}}) {
    const std::string t = a + "topologies/" + name + "/";
    node.set(t + "type", "unstructured").set(t + "coordset", "s");
    node.set(t + "elements/shape", shape).set(t + "elements/connectivity", ids);
    if (*field)
      node.set(a + "fields/" + field + "/association", "element")
          .set(a + "fields/" + field + "/topology", name)
          .set(a + "fields/" + field + "/values", value);
  }
  ASSERT_EQ(catalyst_execute(node.get()), catalyst_status_ok);
  EXPECT_EQ(answers_of("first"), (std::vector{10.0, 20.0}));
  const std::vector<double> heat = answers_of("solid", "heat");
  ASSERT_EQ(heat.size(), 2u);
  EXPECT_EQ(heat[0], 7.0);
  EXPECT_TRUE(std::isnan(heat[1])); // of the other domain, which has no solid
  TestNode results;
  ASSERT_EQ(catalyst_results(results.get()), catalyst_status_ok);
  EXPECT_EQ(conduit_node_as_int64(conduit_node_fetch(results.get(), "catalyst/insitu/failures")),
            0);
}

/// An amrmesh, and its regrid.
TEST_F(Catalyst, AnAmrmeshIsAnAdaptiveMesh) {
  std::ofstream(folder_ / "scene.yaml")
      << "insitu: 1\nprobes:\n"
         "  - {name: p, mesh: grid, points: [[0.5, 0.5, 0.5], [1.25, 1.25, 1.25]], fields: [n]}\n";
  ASSERT_EQ(catalyst_initialize(start().get()), catalyst_status_ok);
  const std::string grid = "catalyst/channels/grid/", data = grid + "data/";
  for (int step = 0; step < 2; ++step) {
    TestNode node = cycle(step);
    node.set(grid + "type", "amrmesh");
    const Block coarse(node, data + "a/", 4, 0.0, 1.0, 0.0);
    const Block fine(node, data + "b/", 4, step == 0 ? 1.0 : 2.0, 0.5, 1000.0);
    node.set(data + "a/state/level", 0).set(data + "b/state/level", 1);
    ASSERT_EQ(catalyst_execute(node.get()), catalyst_status_ok);
    const std::vector<double> n = answers_of("p");
    ASSERT_EQ(n.size(), 2u);
    EXPECT_NEAR(n[0], 0.0, 1e-12); // centres of cells: sums of eight products, rounded
    if (step == 0)
      EXPECT_NEAR(n[1], 1000.0, 1e-9);
    else // three fourths of the way from cell 0's centre to that of cell 21, of the coarse ones
      EXPECT_NEAR(n[1], 15.75, 1e-12);
    node.remove(data + "b/state");
    EXPECT_NE(catalyst_execute(node.get()), catalyst_status_ok);
  }
}

TEST_F(Catalyst, ScenesOfTheEnvironmentComeFirst) {
  std::ofstream(folder_ / "other.yaml") << "nonsense: 3\n";
  setenv("INSITU_SCENE", (folder_ / "other.yaml").c_str(), 1);
  EXPECT_EQ(int(catalyst_initialize(start().get())), 1000 + INSITU_ERROR_SCENE);
  unsetenv("INSITU_SCENE");
  TestNode two = start();
  two.set("catalyst/scripts/more", (folder_ / "other.yaml").string());
  EXPECT_EQ(int(catalyst_initialize(two.get())), 1000 + INSITU_ERROR_UNSUPPORTED);
}

} // namespace
