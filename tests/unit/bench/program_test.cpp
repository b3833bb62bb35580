#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>

namespace {

struct Outcome {
  int exit_code = -1;
  std::string out;
};

Outcome run(const std::string& arguments, const std::string& redirect = "2>&1") {
  Outcome r;
  FILE* pipe = popen((std::string(INSITU_BENCH) + " " + arguments + " " + redirect).c_str(), "r");
  if (!pipe)
    return r;
  char text[4096];
  for (std::size_t n; (n = fread(text, 1, sizeof text, pipe)) > 0;)
    r.out.append(text, n);
  const int status = pclose(pipe);
  r.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return r;
}

/// The number after the first "key": at or behind `from`; NaN if there is none.
double number(const std::string& json, const std::string& key, std::size_t from = 0) {
  const std::size_t at = json.find("\"" + key + "\": ", from);
  if (at == std::string::npos)
    return std::nan("");
  const std::string value = json.substr(at + key.size() + 4, 40);
  char* end = nullptr;
  const double x = std::strtod(value.c_str(), &end);
  return end == value.c_str() ? std::nan("") : x;
}

const char* const keys[] = {"cells", "queries", "threads",    "build_s", "refit_s",  "mqps",
                            "bytes", "lost",    "bytes_peak", "wrong",   "max_error"};

TEST(BenchProgram, HelpExplains) {
  for (const char* arguments : {"--help", "commit --help", "locate -h"}) {
    const Outcome r = run(arguments, "2>/dev/null");
    EXPECT_EQ(r.exit_code, 0);
    for (const char* option : {"--shape", "--cells", "--jitter", "--queries", "--threads",
                               "--accuracy", "--repetitions", "--json", "--peers", "--mesh"})
      EXPECT_NE(r.out.find(option), std::string::npos) << option;
  }
}

TEST(BenchProgram, UnusableArgumentsEndWithTwoAndNameTheArgument) {
  const struct {
    const char *arguments, *named;
  } cases[] = {{"", "command"},
               {"fly", "fly"},
               {"locate --shape cube", "--shape"},
               {"locate --cells", "--cells"},
               {"locate --cells -5", "--cells"},
               {"locate --cells 10x", "--cells"},
               {"locate --jitter nan", "--jitter"},
               {"locate --jitter 0.9", "--jitter"},
               {"locate --queries all", "--queries"},
               {"locate --accuracy good", "--accuracy"},
               {"commit --threads 1.5", "--threads"},
               {"commit --repetitions 0", "--repetitions"},
               {"commit --colour red", "--colour"},
               {"commit --cells 10 --json /nonexistent/folder/x.json", "--json"},
               {"locate --mesh /nonexistent.vtu", "--mesh"}};
  for (const auto& c : cases) {
    const Outcome r = run(c.arguments);
    EXPECT_EQ(r.exit_code, 2) << c.arguments;
    EXPECT_NE(r.out.find(c.named), std::string::npos) << c.arguments << ": " << r.out;
  }
}

TEST(BenchProgram, LocateAnswersRightlyOnEveryShapeAndPattern) {
  for (const char* shape : {"hex", "tet", "wedge", "pyramid", "mixed"})
    for (const char* pattern : {"uniform", "random", "sorted", "march"})
      for (const char* accuracy : {"standard", "exact"}) {
        const Outcome r = run("locate --cells 500 --repetitions 1 --json - --shape " +
                                  std::string(shape) + " --queries " + pattern + " --accuracy " +
                                  accuracy + (accuracy[0] == 'e' ? " --renumber" : ""),
                              "");
        ASSERT_EQ(r.exit_code, 0) << r.out;
        for (const char* key : keys)
          EXPECT_TRUE(std::isfinite(number(r.out, key))) << key << '\n' << r.out;
        EXPECT_GT(number(r.out, "cells"), 100.0);
        EXPECT_GT(number(r.out, "queries"), 100.0);
        EXPECT_GT(number(r.out, "mqps"), 0.0);
        EXPECT_GT(number(r.out, "bytes"), 0.0);
        EXPECT_EQ(number(r.out, "lost"), 0.0) << shape << ' ' << pattern;
        EXPECT_EQ(number(r.out, "wrong"), 0.0) << shape << ' ' << pattern;
        EXPECT_LT(number(r.out, "max_error"), 1e-12) << shape << ' ' << pattern;
      }
}

TEST(BenchProgram, CommitReportsEveryPhase) {
  for (const char* shape : {"hex", "mixed"}) {
    const Outcome r =
        run(std::string("commit --cells 3000 --repetitions 2 --json - --shape ") + shape, "");
    ASSERT_EQ(r.exit_code, 0) << r.out;
    for (const char* key : keys)
      EXPECT_TRUE(std::isfinite(number(r.out, key))) << key << '\n' << r.out;
    for (const char* timing : {"first_commit", "validate", "rebuild_morton_cold", "rebuild_morton",
                               "rebuild_medium_cold", "rebuild_medium", "refit", "refit_medium"}) {
      const std::size_t at = r.out.find("\"" + std::string(timing) + "\": {");
      ASSERT_NE(at, std::string::npos) << timing;
      EXPECT_GT(number(r.out, "median", at), 0.0) << timing;
      EXPECT_LE(number(r.out, "min", at), number(r.out, "max", at)) << timing;
    }
    EXPECT_GT(number(r.out, "refit_over_medium_rebuild"), 0.0);
    EXPECT_EQ(number(r.out, "lost"), 0.0);
    EXPECT_EQ(number(r.out, "wrong"), 0.0);
    EXPECT_LT(number(r.out, "max_error"), 1e-12);
  }
}

TEST(BenchProgram, PeersAnswerTheSameQueriesOrAreSaidToBeAbsent) {
  const Outcome table = run("locate --cells 300 --repetitions 1 --peers");
  ASSERT_EQ(table.exit_code, 0) << table.out;
  const Outcome r = run("locate --cells 300 --repetitions 1 --peers --queries random --json -", "");
  ASSERT_EQ(r.exit_code, 0) << r.out;
  const std::size_t peers = r.out.find("\"peers\": {");
  ASSERT_NE(peers, std::string::npos) << r.out;
  if (!INSITU_BENCH_HAS_VTK) {
    EXPECT_NE(table.out.find("without VTK"), std::string::npos);
    return;
  }
  for (const char* peer :
       {"vtkStaticCellLocator", "vtkCellTreeLocator", "vtkCellLocator", "vtkProbeFilter"}) {
    EXPECT_NE(table.out.find(peer), std::string::npos);
    const std::size_t at = r.out.find("\"" + std::string(peer) + "\": {", peers);
    ASSERT_NE(at, std::string::npos) << peer;
    EXPECT_EQ(number(r.out, "queries", at), number(r.out, "queries"));
    EXPECT_GT(number(r.out, "mqps", at), 0.0);
    EXPECT_LT(number(r.out, "max_error", at), 1e-9) << peer;
  }
}

TEST(BenchProgram, WritesJsonAndStaysQuietInAPipe) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("insitu_bench_test_" + std::to_string(getpid()) + ".json");
  const Outcome r =
      run("locate --cells 300 --repetitions 1 --json " + file.string(), "2>&1 >/dev/null");
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_EQ(r.out, ""); // no progress on standard error
  std::stringstream json;
  json << std::ifstream(file).rdbuf();
  EXPECT_EQ(number(json.str(), "lost"), 0.0) << json.str();
  std::filesystem::remove(file);
}

} // namespace
