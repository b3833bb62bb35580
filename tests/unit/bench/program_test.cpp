#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

#include "program.h"

using insitu::test::number;
using insitu::test::Outcome;
using insitu::test::run;

namespace {

const char* const keys[] = {"cells", "queries", "threads",    "build_s", "refit_s",  "mqps",
                            "bytes", "lost",    "bytes_peak", "wrong",   "max_error"};

TEST(BenchProgram, HelpExplains) {
  for (const char* arguments : {"--help", "commit --help", "locate -h", "torture -h", "scale -h"}) {
    const Outcome r = run(arguments, "2>/dev/null");
    EXPECT_EQ(r.exit_code, 0);
    for (const char* option :
         {"--shape", "--cells", "--jitter", "--queries", "--threads", "--accuracy", "--repetitions",
          "--json", "--peers", "--mesh", "--kind", "--numbering", "--fields", "--peer-points",
          "--csv", "--svg"})
      EXPECT_NE(r.out.find(option), std::string::npos) << option;
  }
}

/// Cells across faces are looked for where numbers do not tell, and there alone.
TEST(BenchProgram, AdvectAccountsForEveryLine) {
  for (const char* mesh : {"--shape hex", "--shape tet", "--shape hex --numbering shuffled"}) {
    const std::string arguments =
        std::string("advect --cells 1000 --points 80 --repetitions 1 ") + mesh;
    const Outcome table = run(arguments, "2>/dev/null");
    EXPECT_EQ(table.exit_code, 0) << mesh;
    EXPECT_EQ(table.out.find("Cells across faces") != std::string::npos,
              std::string(mesh) != "--shape hex")
        << table.out;
    const Outcome json = run(arguments + " --json -", "2>/dev/null");
    int rows = 0;
    for (std::size_t at = json.out.find("{\"name\""); at != std::string::npos;
         at = json.out.find("{\"name\"", at + 1), ++rows) {
      EXPECT_EQ(number(json.out, "lost", at), 0) << mesh;
      EXPECT_GT(number(json.out, "steps_per_s", at), 0) << mesh;
      EXPECT_LT(number(json.out, "error", at), 0.02) << mesh; // cells, euler is none of the rows
      EXPECT_LE(number(json.out, "across", at), number(json.out, "error", at) + 1e-15) << mesh;
    }
    EXPECT_EQ(rows, 20) << mesh;
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
               {"locate --kind odd", "--kind"},
               {"locate --numbering upwards", "--numbering"},
               {"locate --fields 0", "--fields"},
               {"locate --cells 10,20", "--cells"},
               {"scale --cells 10,,20", "--cells"},
               {"scale --queries random", "--queries"},
               {"commit --svg x.svg", "--svg"},
               {"paper", "morrical"},
               {"paper somebody", "somebody"},
               {"commit --quick", "--quick"},
               {"scale --cells 10 --svg /nonexistent/folder/x.svg", "--svg"},
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
  int number_of_case = 0;
  for (const char* shape : {"hex", "tet", "wedge", "pyramid", "mixed"})
    for (const char* pattern :
         {"uniform", "random", "sorted", "march", "vertices", "edges", "faces"})
      for (const char* accuracy : {"standard", "exact"}) {
        if (accuracy[0] == 'e' && ++number_of_case % 3 > 0) // each shape and pattern, not each pair
          continue;
        const Outcome r = run("locate --cells 500 --repetitions 1 --json - --shape " +
                                  std::string(shape) + " --queries " + pattern + " --accuracy " +
                                  accuracy + (accuracy[0] == 'e' ? " --numbering shuffled" : ""),
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
        EXPECT_EQ(number(r.out, "not_lowest"), 0.0) << shape << ' ' << pattern;
        EXPECT_LT(number(r.out, "max_error"), 1e-12) << shape << ' ' << pattern;
        EXPECT_GT(number(r.out, "single_us"), 0.0);
        EXPECT_EQ(std::isfinite(number(r.out, "exact_over_standard")), accuracy[0] == 's');
      }
}

TEST(BenchProgram, LocateAnswersRightlyOnEveryKindOfMesh) {
  for (const char* kind : {"even", "graded", "layers", "sparse"})
    for (const char* pattern : {"random", "march", "faces"}) {
      const Outcome r = run(std::string("locate --cells 3000 --repetitions 1 --json - --kind ") +
                                kind + " --queries " + pattern,
                            "");
      ASSERT_EQ(r.exit_code, 0) << r.out;
      EXPECT_NE(r.out.find(std::string("\"kind\": \"") + kind + "\""), std::string::npos);
      EXPECT_NEAR(number(r.out, "cells"), 3000.0, 700.0) << kind; // a cubic number, about
      EXPECT_EQ(number(r.out, "lost"), 0.0) << kind << ' ' << pattern;
      EXPECT_EQ(number(r.out, "wrong"), 0.0) << kind << ' ' << pattern;
      EXPECT_EQ(number(r.out, "not_lowest"), 0.0) << kind << ' ' << pattern;
    }
}

TEST(BenchProgram, FurtherFiguresOfLocate) {
  const Outcome random =
      run("locate --cells 500 --repetitions 1 --queries random --fields 5 --json -", "");
  ASSERT_EQ(random.exit_code, 0) << random.out;
  for (const char* key : {"sort_ns", "mqps_unsorted", "fields_over_one", "hinted_us"})
    EXPECT_GT(number(random.out, key), 0.0) << key;
  double reasons = 0.0;
  for (const char* reason : {"outside", "certified", "exact", "on_face", "on_edge", "on_vertex"})
    reasons += number(random.out, std::string("reason_") + reason);
  EXPECT_EQ(reasons, number(random.out, "queries"));
  const Outcome faces = run("locate --cells 500 --repetitions 1 --queries faces --json -", "");
  EXPECT_GT(number(faces.out, "boundary_over_random"), 0.0);
}

TEST(BenchProgram, ScaleWritesATableAndAPlot) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("insitu_bench_scale_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::string csv = (folder / "a.csv").string(), svg = (folder / "a.svg").string();
  const Outcome r =
      run("scale --cells 500,1000 --repetitions 1 --json - --csv " + csv + " --svg " + svg, "");
  ASSERT_EQ(r.exit_code, 0) << r.out;
  EXPECT_EQ(number(r.out, "cells"), 512.0);
  EXPECT_GT(number(r.out, "random_ns"), 0.0);
  std::ifstream table(csv);
  std::string line;
  int rows = 0;
  const auto commas = [&] { return std::count(line.begin(), line.end(), ','); };
  ASSERT_TRUE(std::getline(table, line));
  const auto columns = commas();
  for (; std::getline(table, line); ++rows)
    EXPECT_EQ(commas(), columns) << line;
  EXPECT_GE(rows, 4); // two meshes, two batches at least
  std::stringstream plot;
  plot << std::ifstream(svg).rdbuf();
  EXPECT_EQ(plot.str().find("<svg"), 0u);
  EXPECT_NE(plot.str().find("</svg>"), std::string::npos);
  EXPECT_EQ(plot.str().find("nan"), std::string::npos);
  std::filesystem::remove_all(folder);
}

TEST(BenchProgram, TortureScoresEveryMethod) {
  const Outcome r = run("torture --points 30 --json -", "");
  ASSERT_EQ(r.exit_code, 0) << r.out;
  EXPECT_EQ(number(r.out, "failures"), 0.0);
  for (const char* method : {"standard_batch", "standard_single", "standard_hinted", "exact_batch",
                             "exact_single", "exact_hinted"})
    EXPECT_NE(r.out.find("\"" + std::string(method) + "\": {\"lost\": "), std::string::npos);
  EXPECT_EQ(r.out.find("vtkStaticCellLocator") != std::string::npos, INSITU_BENCH_HAS_VTK != 0);
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

TEST(BenchProgram, SectionsAnswerAsPackedArraysDo) {
  const Outcome r =
      run("sections --cells 1000 --points 2000 --size 32 --repetitions 1 --json -", "");
  EXPECT_EQ(r.exit_code, 0) << r.out;
  for (const char* text : {"\"same_samples\": true", "\"work\": \"particles\""})
    EXPECT_NE(r.out.find(text), std::string::npos) << r.out;
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

TEST(BenchProgram, AmrTellsTheErrorAtCentresAndStandsBesideOpenVkl) {
  const std::string arguments = "amr --cells 5000 --points 3000 --repetitions 1 --peers";
  const Outcome table = run(arguments, "2>/dev/null");
  ASSERT_EQ(table.exit_code, 0) << table.out;
  EXPECT_NE(table.out.find("no samples by Open VKL") == std::string::npos,
            INSITU_BENCH_HAS_OPENVKL == 0);
  const Outcome r = run(arguments + " --json -", "2>/dev/null");
  ASSERT_EQ(r.exit_code, 0) << r.out;
  std::vector<std::string> rows = {
      "patches, dual mesh",        "the same as plain hexahedra", "patches, nearest",
      "octree leaves, dual mesh",  "octree leaves, nearest",      "front octree, dual mesh",
      "front octree, plain cells", "random octree, dual mesh",    "random octree, plain cells"};
  if (INSITU_BENCH_HAS_OPENVKL) {
    rows.insert(rows.end(), {"Open VKL, octant", "Open VKL, finest"});
    EXPECT_GT(number(r.out, "ratio_random"), 0.0);
    EXPECT_GT(number(r.out, "ratio_raster"), 0.0);
  }
  for (const std::string& row : rows) {
    const std::size_t at = r.out.find("\"" + row + "\": {");
    ASSERT_NE(at, std::string::npos) << row;
    EXPECT_NE(table.out.find(row), std::string::npos);
    for (const char* key : {"build_s", "mqps", "mqps_raster", "bytes", "leaves"})
      EXPECT_GT(number(r.out, key, at), 0.0) << row << ' ' << key;
    EXPECT_LT(number(r.out, "max_error_at_centres", at), row[0] == 'O' ? 1e-5 : 1e-14) << row;
    EXPECT_EQ(number(r.out, "wrong_at_centres", at), 0.0) << row;
    EXPECT_EQ(number(r.out, "lost", at), 0.0) << row;
  }
  const std::size_t dual = r.out.find("\"patches, dual mesh\": {");
  for (const char* key : {"compression", "gridlets", "cubes", "stitching"})
    EXPECT_GT(number(r.out, key, dual), 0.0) << key;
  for (const char* key : {"folded", "repaired"})
    EXPECT_EQ(number(r.out, key, dual), 0.0) << key; // levels differ by one
  for (const std::string mesh : {"blocks", "random octree"})
    for (const std::string shows : {"shell", "inside", "all"}) {
      const std::size_t at = r.out.find("\"frames of " + mesh + ", " + shows + "\": {");
      ASSERT_NE(at, std::string::npos) << mesh << ", " << shows;
      for (const char* key : {"primitives", "refresh_s", "ranges_s", "reclassify_s", "cull_s",
                              "frame_s", "frame_culled_s", "bytes"})
        EXPECT_GT(number(r.out, key, at), 0.0) << mesh << ", " << shows << ' ' << key;
      EXPECT_EQ(number(r.out, "culled", at) > 0.0, shows != "all");
      EXPECT_EQ(number(r.out, "differs", at), 0.0) << mesh << ", " << shows;
    }
}

TEST(BenchProgram, AmrByNumberOfLeaves) {
  const Outcome r = run("amr --cells 5000 --repetitions 1 --sizes --json -", "2>/dev/null");
  ASSERT_EQ(r.exit_code, 0) << r.out;
  for (const std::string mesh : {"blocks", "front octree", "balanced octree", "random octree"}) {
    double before = 0;
    int count = 0;
    for (std::size_t at = r.out.find("\"" + mesh + " of "); at != std::string::npos;
         at = r.out.find("\"" + mesh + " of ", at + 1), ++count) {
      const auto of = [&](const char* key) { return number(r.out, key, at); };
      EXPECT_GE(of("leaves"), before);
      before = of("leaves");
      for (const char* key : {"build_s", "compression", "data_bytes", "peak_bytes", "bytes"})
        EXPECT_GT(of(key), 0.0) << mesh << ' ' << key;
      EXPECT_EQ(of("stitching"),
                of("tetrahedra") + of("pyramids") + of("wedges") + of("hexahedra"));
      EXPECT_EQ(of("folded") > 0.0, mesh == "random octree"); // only there levels jump
      EXPECT_EQ(of("folded_after"), 0.0);
    }
    EXPECT_EQ(count, 4) << mesh;
  }
  EXPECT_EQ(r.out.find("patches, dual mesh"), std::string::npos) << r.out;
  EXPECT_EQ(r.out.find("},\n}"), std::string::npos) << r.out;
  EXPECT_EQ(run("render --sizes", "2>/dev/null").exit_code, 2);
}

TEST(BenchProgram, RenderHoldsTheWorkloadsFrameAgainstOpenVklOrSaysThatItIsAbsent) {
  const std::string arguments = "render --cells 4000 --size 48 --repetitions 1 --peers";
  const Outcome table = run(arguments, "2>/dev/null");
  ASSERT_EQ(table.exit_code, 0) << table.out;
  const Outcome r = run(arguments + " --json -", "2>/dev/null");
  ASSERT_EQ(r.exit_code, 0) << r.out;
  const std::size_t at = r.out.find("\"openvkl\": {");
  if (!INSITU_BENCH_HAS_OPENVKL) {
    EXPECT_NE(table.out.find("no frame by Open VKL"), std::string::npos) << table.out;
    EXPECT_EQ(at, std::string::npos);
    return;
  }
  ASSERT_NE(at, std::string::npos) << r.out;
  const double samples = number(r.out, "ours_samples", at);
  EXPECT_GT(samples, 10'000.0);
  for (const std::string way : {"intervals", "packets"}) {
    EXPECT_NE(table.out.find("Open VKL, " + way), std::string::npos);
    EXPECT_GT(number(r.out, "ratio_" + way, at), 0.0);
    // The same lattice but for rays that pass between two of its points; cells are curved, and
    // floats round.
    EXPECT_NEAR(number(r.out, way + "_samples", at), samples, 0.01 * samples);
    EXPECT_NEAR(number(r.out, way + "_rms_error", at), number(r.out, "ours_rms_error", at), 1e-3);
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
