// A run that is killed at any moment leaves whole files, and unfinished ones under a name of their
// own that the next run removes. The run is the miniapp, in a process of its own.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <gtest/gtest.h>
#include <iostream>
#include <random>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <yaml-cpp/yaml.h>

#include "coupled.h"
#include "output/files/atomic_file.h"
#include "output/files/file_lock.h"
#include "output/image/png.h"
#include "unit/output/netcdf_file.h"

extern char** environ;

namespace {

const std::string scene = R"(
insitu: 1
probes:
  - {name: grid, points: {grid: {min: [0, 0, 0], max: [1, 1, 1], counts: [6, 6, 6]}}, output: [csv, vtp, json, netcdf]}
tracers:
  - name: paths
    velocity: velocity
    seeds: {sphere: {center: [0.4, 0.4, 0.4], radius: 0.3, count: 100}}
    output: [csv, vtp, netcdf]
  - {name: lines, kind: streamline, velocity: velocity, until: {duration: 0.1}, every: 3,
     seeds: {sphere: {center: [0.3, 0.3, 0.3], radius: 0.2, count: 50}}}
frames:
  - {name: blast, size: [128, 128], volume: {field: density}, every: 2}
)";

/// Starts the miniapp, quietly.
pid_t start(const test::Folder& folder, const std::string& cycles) {
  std::vector<std::string> words{SEDOV_PROGRAM,
                                 "--quiet",
                                 "--cells",
                                 "10",
                                 "--cycles",
                                 cycles,
                                 "--end",
                                 "1000",
                                 "--scene",
                                 folder / "scene.yaml",
                                 "--output",
                                 folder / "out",
                                 "--library-threads",
                                 "2"};
  std::vector<char*> arguments;
  for (std::string& w : words)
    arguments.push_back(w.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = -1;
  const int error =
      ::posix_spawn(&child, SEDOV_PROGRAM, &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  return error == 0 ? child : -1;
}

bool unfinished(const std::string& name) {
  return name.ends_with(insitu::output::part_suffix);
}

/// What a look at the folder found.
struct Seen {
  int files = 0, unfinished = 0, locks = 0, cut_lines = 0;
  std::vector<int> entries; ///< cycles on the page of the run
};

/// The cycles of the entries of run.js. Expects a script that runs: each line is whole, or a
/// comment (output/page/run_page.h); the last one may be cut.
std::vector<int> entries_of(const std::string& script) {
  std::vector<int> cycles;
  std::istringstream lines(script);
  std::string line;
  for (bool header = true; std::getline(lines, line); header = false) {
    if (header || line.starts_with("//"))
      continue;
    EXPECT_TRUE(line.starts_with("insitu.push({\"cycle\":") && line.ends_with("});")) << line;
    const std::string entry = line.substr(12, line.size() - 14);
    EXPECT_NO_THROW(cycles.push_back(YAML::Load(entry)["cycle"].as<int>())) << entry;
  }
  return cycles;
}

/// Expects every file that bears its final name to be whole.
Seen look(const std::string& folder) {
  Seen seen;
  std::error_code error;
  if (!std::filesystem::exists(folder, error))
    return seen;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) // the next run's to take
    seen.locks += entry.path().extension() == insitu::output::lock_suffix;
  for (auto [name, content] : runs::files_of(folder)) {
    SCOPED_TRACE(name);
    if (unfinished(name)) {
      ++seen.unfinished;
      continue;
    }
    ++seen.files;
    if (name.ends_with(".png")) {
      const insitu::output::PngImage image = insitu::output::read_png(folder + "/" + name);
      EXPECT_EQ(image.width, 128);
      EXPECT_EQ(image.height, 128);
    } else if (name.ends_with(".csv")) {
      // output/files/csv.h: a kill in the midst of an append may cut the last line; the next run
      // mends it.
      if (!content.empty() && content.back() != '\n') {
        ++seen.cut_lines;
        content.resize(content.rfind('\n') + 1); // npos + 1 is 0
      }
      if (!content.empty()) {
        EXPECT_NO_THROW((void)runs::parse_table(content));
      }
    } else if (name.ends_with(".nc")) {
      EXPECT_NO_THROW({
        const test::NetcdfFile file(folder + "/" + name);
        const auto& cycles = file["cycle"].integers;
        EXPECT_EQ(cycles.size(), file.records());
        EXPECT_TRUE(std::is_sorted(cycles.begin(), cycles.end()));
      });
    } else if (name.ends_with(".json")) {
      EXPECT_NO_THROW((void)YAML::Load(content));
      EXPECT_TRUE(content.ends_with("}\n"));
    } else if (name.ends_with(".vtp") || name.ends_with(".pvd")) {
      EXPECT_TRUE(content.ends_with("</VTKFile>\n"));
      for (std::size_t at = 0; (at = content.find("file=\"", at)) != std::string::npos;) {
        at += 6;
        EXPECT_TRUE(
            std::filesystem::exists(folder + "/" + content.substr(at, content.find('"', at) - at)));
      }
    } else if (name == "index.html") {
      EXPECT_TRUE(content.ends_with("</html>\n"));
    } else if (name == "run.js") {
      seen.entries = entries_of(content);
    } else {
      ADD_FAILURE() << "a file that the scene did not ask for";
    }
  }
  return seen;
}

TEST(KilledRun, LeavesWholeFilesAndTheNextOneCleansUp) {
  const test::Folder folder;
  test::put(folder / "scene.yaml", scene);
  std::mt19937 random(20240521);
  std::uniform_int_distribution<int> microseconds(3'000, 250'000);
  int killed = 0, cut_lines = 0, left_behind = 0, locks = 0;
  for (int i = 0; i < 10; ++i) {
    const pid_t child = start(folder, "1000000");
    ASSERT_GT(child, 0);
    std::this_thread::sleep_for(std::chrono::microseconds(microseconds(random)));
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    killed += WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
    const Seen seen = look(folder / "out");
    cut_lines += seen.cut_lines;
    left_behind += seen.unfinished;
    locks += seen.locks;
    EXPECT_LE(seen.unfinished, 4) << "what earlier runs left was not removed";
  }
  std::cout << killed << " of 10 runs killed; they left " << left_behind << " unfinished files and "
            << cut_lines << " tables with a cut last line\n";
  EXPECT_EQ(killed, 10);
  EXPECT_GT(locks, 0) << "no run was killed while its session was open";

  std::filesystem::create_directories(folder / "out");
  test::put(folder / "out/blast_000007.png.1-0" + std::string(insitu::output::part_suffix), "half");
  const pid_t child = start(folder, "12");
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  const Seen seen = look(folder / "out");
  EXPECT_EQ(seen.unfinished, 0);
  EXPECT_EQ(seen.locks, 0);
  EXPECT_EQ(seen.cut_lines, 0);
  EXPECT_GT(seen.files, 40);
  // Nothing of the killed runs is left in the tables.
  const runs::Table t = runs::parse_table(test::content(folder / "out/grid.csv"));
  ASSERT_EQ(t.rows.size(), 13u * 216);
  for (std::size_t i = 0; i < t.rows.size(); ++i)
    ASSERT_EQ(t.number(i, "cycle"), double(i / 216));
  const test::NetcdfFile grid(folder / "out/grid.nc");
  ASSERT_EQ(grid.records(), 13u);
  EXPECT_EQ(grid["pressure"].doubles.size(), 13u * 216);
  EXPECT_EQ(test::NetcdfFile(folder / "out/paths.nc").records(),
            runs::parse_table(test::content(folder / "out/paths.csv")).rows.size());
  // Nor on the page: each cycle, and the end of the session.
  EXPECT_EQ(seen.entries, (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 12}));
}

} // namespace
