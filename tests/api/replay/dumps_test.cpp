// Dumps of Catalyst's calls, as its stub writes them: files of bytes and their schemas, a process
// each.
#include "dumps.h"

namespace {

struct Dumps : DumpReplay {
  /// Two processes with a box of two cells each, beside each other along x; f is x + cycle.
  void dump(int cycle, int process) const {
    TestNode node;
    const std::string data = "catalyst/channels/grid/data/";
    node.set("catalyst/state/timestep", cycle).set("catalyst/state/time", 0.5 * cycle);
    node.set("catalyst/channels/grid/type", "mesh");
    if (cycle > 4) // each process numbers its own domain
      node.set(data + "state/domain_id", 0);
    node.set(data + "coordsets/c/type", "uniform").set(data + "coordsets/c/dims/i", 3);
    node.set(data + "coordsets/c/dims/j", 2).set(data + "coordsets/c/dims/k", 2);
    node.set(data + "coordsets/c/origin/x", 2.0 * process);
    node.set(data + "topologies/t/type", "uniform").set(data + "topologies/t/coordset", "c");
    node.set(data + "fields/f/association", "vertex").set(data + "fields/f/topology", "t");
    std::vector<double> f;
    for (int v = 0; v < 12; ++v)
      f.push_back(2 * process + v % 3 + cycle);
    node.set(data + "fields/f/values", f);
    DumpWriter(node, name_of(cycle, process));
  }
  std::string name_of(int cycle, int process) const { return dump_of(cycle, process, 2); }
  void SetUp() override {
    DumpReplay::SetUp();
    put("dumps.yaml", "insitu: 1\nprobes:\n  - {name: g, mesh: grid, points: [[0.5, 0.5, 0.5], "
                      "[3.25, 0.5, 0.5]], fields: [f]}\n");
    for (int cycle = 0; cycle < 11; ++cycle) // 10 is not between 1 and 2
      for (int process = 0; process < 2; ++process)
        dump(cycle, process);
  }
};

TEST_F(Dumps, OfSeveralProcessesAreOneMesh) {
  const Outcome o = run("--scene dumps.yaml --out out .");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> rows = Replay::rows("out/g.csv");
  ASSERT_EQ(rows.size(), 22u);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double cycle = double(r / 2);
    EXPECT_EQ(rows[r].at("cycle"), cycle);
    EXPECT_EQ(rows[r].at("time"), 0.5 * cycle);
    EXPECT_EQ(rows[r].at("f"), (r % 2 == 0 ? 0.5 : 3.25) + cycle);
  }
}

TEST_F(Dumps, ThatAreCutShortOrMissingAreNamed) {
  const auto expect = [&](const std::string& text) {
    const Outcome o = run("--scene dumps.yaml --out out .");
    EXPECT_EQ(o.code, 1);
    EXPECT_NE(o.err.find(text), std::string::npos) << o.err;
  };
  fs::resize_file(name_of(3, 1), 150);
  expect("execute_invc3_params.conduit_bin.2.1: /catalyst/");
  dump(3, 1);
  fs::resize_file(name_of(3, 1) + "_json", 150);
  expect("execute_invc3_params.conduit_bin.2.1_json: is no JSON");
  fs::remove(name_of(3, 1));
  expect("the dump of process 1 of 2 is missing");
  const Outcome o = run("--reverse .");
  EXPECT_EQ(o.code, 2) << o.err;
}

/// The scene and the output folder are those of the run, or the command line's.
TEST_F(Dumps, CheckIsADryRun) {
  const std::vector<std::string> lines = {
      "mesh 'grid': 4 cells, 24 vertices\n", "  field 'f' on vertices, 1 component\n", "11 steps\n",
      "would write\n  nothing/g.csv (every cycle)\n", " are kept"};
  expect_checked("--scene dumps.yaml .", lines);
  put("dumps.txt",
      contents(path("dumps.yaml"))); // whatever the scene's name, and in any environment
  ::setenv("INSITU_SCENE", "other.yaml", 1);
  expect_checked("--scene dumps.txt .", lines);
  ::unsetenv("INSITU_SCENE");
  TestNode start;
  start.set("catalyst/scripts/scene/filename", "dumps.yaml").set("catalyst/mpi_comm", 12345);
  start.set("catalyst/insitu/output", "nothing");
  for (int process = 0; process < 2; ++process)
    DumpWriter(start, path("initialize_params.conduit_bin.2." + std::to_string(process)));
  Outcome o = run("--check .");
  EXPECT_EQ(o.code, 0) << o.err;
  for (const std::string& line : lines)
    EXPECT_NE(o.out.find(line), std::string::npos) << line << o.out;
  EXPECT_FALSE(fs::exists(folder / "nothing"));
  o = run("--plan .");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("probe 'g' of mesh 'grid'"), std::string::npos) << o.out;
  o = run("--check --plan .");
  EXPECT_EQ(o.code, 2) << o.err;
}

/// Every call's meshes are looked at; one that is refused is told, and the exit code is 1.
TEST_F(Dumps, AreValidated) {
  Outcome o = run("--validate .");
  EXPECT_EQ(o.code, 0) << o.err;
  const std::string line = "_params.conduit_bin.2.0: accepted, 4 cells, 0 ghost, 0 inverted";
  for (int cycle = 0; cycle < 11; ++cycle)
    EXPECT_NE(o.out.find("execute_invc" + std::to_string(cycle) + line), std::string::npos)
        << o.out;
  EXPECT_FALSE(fs::exists(folder / "out"));
  TestNode node;
  const std::string data = "catalyst/channels/grid/data/";
  std::vector<double> xyz{0, 1, 0, 0};
  std::vector<std::int32_t> ids{0, 1, 2, 9};
  for (const char* axis : {"x", "y", "z"})
    node.set(data + "coordsets/c/values/" + axis, xyz);
  node.set(data + "coordsets/c/type", "explicit").set(data + "topologies/t/coordset", "c");
  node.set(data + "topologies/t/type", "unstructured");
  node.set(data + "topologies/t/elements/shape", "tet");
  node.set(data + "topologies/t/elements/connectivity", ids);
  DumpWriter(node, dump_of(11, 0, 1));
  o = run("--validate .");
  EXPECT_EQ(o.code, 1) << o.err;
  EXPECT_NE(o.out.find("execute_invc11_params.conduit_bin.1.0: refused"), std::string::npos)
      << o.out;
  EXPECT_NE(o.out.find("cell 0: vertex 3 has id 9, 0 to 3 expected"), std::string::npos) << o.out;
}

/// Misspelt fields, meshes and keys are named, with the nearest name.
TEST_F(Dumps, CheckNamesWhatIsMisspelt) {
  const auto expect = [&](const std::string& probe, int code, const std::string& text) {
    put("typo.yaml",
        "insitu: 1\nprobes:\n  - {name: g, points: [[0.5, 0.5, 0.5]], " + probe + "}\n");
    const Outcome o = run("--check --scene typo.yaml --out nothing .");
    EXPECT_EQ(o.code, code) << o.err;
    EXPECT_NE(o.err.find(text), std::string::npos) << o.err;
    EXPECT_FALSE(fs::exists(folder / "nothing"));
  };
  expect("mesh: grid, fields: [ff]", 3, "did you mean 'f'?");
  expect("mesh: gird, fields: [f]", 3, "did you mean 'grid'?");
  expect("mesh: grid, feilds: [f]", 1, "did you mean 'fields'?");
  fs::resize_file(name_of(0, 1), 150);
  expect("mesh: grid, fields: [f]", 1, "execute_invc0_params.conduit_bin.2.1: /catalyst/");
}

} // namespace
