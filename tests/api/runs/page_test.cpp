// The page of a run, from whole runs: what it holds of each cycle, and what it costs.
#include <filesystem>
#include <gtest/gtest.h>
#include <numeric>
#include <sstream>
#include <yaml-cpp/yaml.h>

#include "coupled.h"

namespace {

using runs::Coupled;

const std::string scene = R"(
insitu: 1
every: 2
probes:
  - {name: few, points: [[0.1, 0.1, 0.1], [9, 9, 9]]}
  - {name: "many & 'x' #1%", points: {line: {from: [0, 0, 0], to: [1, 1, 1], count: 100}}, every: 4}
tracers:
  - {name: t, velocity: velocity, seeds: {sphere: {center: [0.3, 0.3, 0.3], radius: 0.2, count: 50}}}
frames:
  - {name: f, size: [16, 16], volume: {field: density}, every: 4}
)";

/// The entries of run.js; JSON is YAML.
std::vector<YAML::Node> entries_of(const test::Folder& folder) {
  std::vector<YAML::Node> entries;
  std::istringstream lines(test::content(folder / "run.js"));
  std::string line;
  EXPECT_TRUE(std::getline(lines, line));
  while (std::getline(lines, line)) {
    EXPECT_TRUE(line.starts_with("insitu.push({") && line.ends_with("});")) << line;
    entries.push_back(YAML::Load(line.substr(12, line.size() - 14)));
  }
  return entries;
}

std::vector<int> cycles_of(const std::vector<YAML::Node>& entries) {
  std::vector<int> cycles;
  for (const YAML::Node& e : entries)
    cycles.push_back(e["cycle"].as<int>());
  return cycles;
}

TEST(Page, HoldsWhatWasDue) {
  const test::Folder folder;
  Coupled run({.scene = scene, .output = folder.path()});
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  run.run(9);
  const insitu::Report before = run.session.report();
  EXPECT_EQ(cycles_of(entries_of(folder)), (std::vector<int>{0, 2, 4, 6, 8}));
  run.session.close();
  const auto entries = entries_of(folder);
  ASSERT_EQ(cycles_of(entries), (std::vector<int>{0, 2, 4, 6, 8, 8}));
  EXPECT_TRUE(entries.back()["finished"].as<bool>());

  const YAML::Node session = entries[0]["session"];
  EXPECT_EQ(session["threads"].as<int>(), 1);
  EXPECT_EQ(session["tables"].size(), 3u);
  const runs::Table table = runs::parse_table(test::content(folder / "few.csv"));
  std::int64_t executions = 0;
  std::vector<double> seconds(5, 0.0);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    SCOPED_TRACE("entry " + std::to_string(i));
    const YAML::Node& e = entries[i];
    executions += e["executions"].as<int>();
    double sum = 0;
    for (std::size_t p = 0; p < 5; ++p) {
      seconds[p] += e["seconds"][p].as<double>();
      sum += e["seconds"][p].as<double>();
    }
    EXPECT_LE(sum, e["wall"].as<double>() * 1.001); // seven digits
    EXPECT_EQ(e["bytes"].size(), std::size_t(INSITU_MEMORY_COUNT));
    ASSERT_EQ(e["tracers"].size(), 1u);
    const auto endings = e["tracers"][0]["endings"].as<std::vector<std::int64_t>>();
    EXPECT_EQ(std::accumulate(endings.begin(), endings.end(), std::int64_t(0)), 50);
    EXPECT_EQ(endings[e["finished"] ? INSITU_END_KILLED : INSITU_END_ALIVE], 50);
    if (e["finished"])
      continue;
    const bool all = e["cycle"].as<int>() % 4 == 0;
    EXPECT_EQ(e["frames"].IsDefined(), all);
    if (all) {
      EXPECT_TRUE(std::filesystem::exists(folder / e["frames"][0]["file"].as<std::string>()));
    }
    ASSERT_EQ(e["probes"].size(), all ? 2u : 1u);
    const YAML::Node few = e["probes"][0];
    EXPECT_NEAR(few["values"][0][0].as<double>(), table.number(2 * i, "density"), 1e-6);
    EXPECT_TRUE(few["values"][1][0].IsNull()) << "a point outside";
    EXPECT_EQ(few["columns"].IsDefined(), i == 0) << "named once";
    if (all) {
      const YAML::Node many = e["probes"][1];
      EXPECT_EQ(many["name"].as<std::string>(), "many & 'x' #1%");
      EXPECT_EQ(many["values"].size(), 16u);
      if (i == 0) {
        EXPECT_EQ(many["total"].as<int>(), 100);
        EXPECT_EQ(many["points"][0]["point"].as<int>(), 0);
        EXPECT_EQ(many["points"][15]["point"].as<int>(), 99);
      }
    }
  }
  // Cycle 9 has nothing due: it is in the last entry's sums.
  EXPECT_EQ(executions, 10);
  EXPECT_NEAR(seconds[0], before.commit_s, 1e-5 * before.commit_s);
  EXPECT_NEAR(seconds[3], before.render_s, 1e-5 * before.render_s);
  EXPECT_GE(seconds[4], before.output_s * (1 - 1e-5)); // and the tables' ends
}

TEST(Page, IsNotThereUnlessSomethingIs) {
  for (const char* text : {"insitu: 1\n", "insitu: 1\nprobes: [{name: p, every: 100, points: "
                                          "[[0, 0, 0]]}]\n"}) {
    const test::Folder folder;
    Coupled run({.scene = text, .output = folder.path()});
    for (int i = 0; i < 3; ++i)
      ASSERT_TRUE(run.step());
    run.session.close();
    EXPECT_EQ(folder.count(), 0u);
  }
  const test::Folder folder;
  const runs::Files files =
      runs::run_to_files({.scene = scene + "page: false\n", .output = folder.path()}, 2);
  EXPECT_EQ(files.count("run.js") + files.count("index.html"), 0u);
  EXPECT_EQ(files.count("few.csv"), 1u);
}

TEST(Page, ARestartedRunContinuesIt) {
  const test::Folder folder;
  {
    Coupled run({.scene = scene, .output = folder.path()});
    ASSERT_TRUE(run.execute());
    run.run(8);
  }
  {
    Coupled run({.scene = scene, .output = folder.path()});
    for (int cycle = 1; cycle <= 4; ++cycle)
      run.solver.advance();
    ASSERT_TRUE(run.execute());
    run.run(6);
  }
  const auto entries = entries_of(folder);
  EXPECT_EQ(cycles_of(entries), (std::vector<int>{0, 2, 4, 6, 6}));
  EXPECT_TRUE(entries[0]["session"].IsDefined());
  EXPECT_TRUE(entries[2]["session"].IsDefined());
  EXPECT_TRUE(entries[2]["probes"][0]["columns"].IsDefined()) << "the new session says what it has";
}

TEST(Page, HasFailuresWithTheirCycle) {
  const test::Folder folder;
  Coupled run({.scene = "insitu: 1\nprobes: [{name: p, points: [[0.1, 0.1, 0.1]], every: 2}]\n"
                        "frames: [{name: f, size: [16, 16], volume: {field: x}, every: 3}]\n",
               .output = folder.path()});
  for (int cycle = 0; cycle < 7; ++cycle)
    EXPECT_EQ(run.session.execute(cycle, cycle), cycle % 3 != 0);
  const auto entries = entries_of(folder);
  ASSERT_EQ(cycles_of(entries), (std::vector<int>{0, 2, 3, 4, 6}));
  ASSERT_EQ(entries[0]["messages"].size(), 1u);
  EXPECT_EQ(entries[0]["messages"][0]["level"].as<std::string>(), "error");
  const std::string text = entries[0]["messages"][0]["text"].as<std::string>();
  EXPECT_NE(text.find("frame 'f'"), std::string::npos) << text;
  EXPECT_NE(text.find("no field 'x'"), std::string::npos) << text;
  int failures = 0;
  for (const YAML::Node& e : entries) {
    failures += e["failures"].as<int>(0);
    EXPECT_EQ(e["messages"].IsDefined(), e["cycle"].as<int>() == 0) << "told once, counted always";
  }
  EXPECT_EQ(failures, 3);
}

TEST(Page, HasWarnings) {
  const test::Folder folder;
  Coupled run({.scene = scene, .output = folder.path()});
  // An inverted cell: a commit that is not strict warns of it.
  for (int i = 0; i < 4; ++i)
    std::swap(run.solver.connectivity[std::size_t(i)], run.solver.connectivity[std::size_t(i + 4)]);
  ASSERT_TRUE(run.execute()) << insitu_last_message();
  const auto entries = entries_of(folder);
  ASSERT_EQ(entries.size(), 1u);
  ASSERT_EQ(entries[0]["messages"].size(), 1u);
  EXPECT_EQ(entries[0]["messages"][0]["level"].as<std::string>(), "warning");
  EXPECT_FALSE(run.log.empty());
  EXPECT_EQ(entries[0]["messages"][0]["text"].as<std::string>(), run.log.front());
}

// Two ranks that share a folder: one page, whole, and both go on.
TEST(Page, ASecondSessionInTheFolderHasNone) {
  const test::Folder folder;
  const auto with = [](const char* name) {
    return std::string("insitu: 1\nprobes: [{name: ") + name + ", points: [[0.1, 0.1, 0.1]]}]\n";
  };
  Coupled a({.scene = with("a"), .output = folder.path()});
  Coupled b({.scene = with("b"), .output = folder.path()});
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(a.step()) << insitu_last_message();
    ASSERT_TRUE(b.step()) << insitu_last_message();
  }
  EXPECT_TRUE(a.log.empty());
  ASSERT_EQ(b.log.size(), 1u) << "told once";
  EXPECT_NE(b.log[0].find("another session"), std::string::npos) << b.log[0];
  EXPECT_EQ(b.session.report().failures, 0);
  a.session.close();
  b.session.close();
  const auto entries = entries_of(folder);
  EXPECT_EQ(cycles_of(entries), (std::vector<int>{1, 2, 3, 3}));
  for (const YAML::Node& e : entries)
    if (e["probes"]) {
      EXPECT_EQ(e["probes"][0]["name"].as<std::string>(), "a");
    }
}

TEST(Page, ThatCannotBeWrittenIsAFailureAndWaits) {
  const test::Folder folder;
  std::filesystem::create_directory(folder / "index.html"); // a folder in its place
  Coupled run({.scene = scene, .output = folder.path()});
  EXPECT_FALSE(run.execute());
  EXPECT_NE(std::string(insitu_last_message()).find("page: "), std::string::npos);
  EXPECT_NE(std::string(insitu_last_message()).find("index.html"), std::string::npos);
  std::filesystem::remove(folder / "index.html");
  run.solver.advance();
  EXPECT_TRUE(run.step()) << insitu_last_message();
  EXPECT_EQ(cycles_of(entries_of(folder)), (std::vector<int>{0, 2})) << "the first one waited";
  EXPECT_EQ(entries_of(folder)[1]["messages"].size(), 1u);
}

} // namespace
