// insitu-bench paper --quick: what every table must hold, on counts and exact figures; seconds and
// rates are looked at only for being there.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

#include "csv_row.h"

namespace {

namespace fs = std::filesystem;

struct Row {
  std::string section, name;
  std::vector<std::string> cells;
  double at(std::size_t column) const {
    char* end = nullptr;
    const double x = std::strtod(cells.at(column).c_str(), &end);
    return end == cells.at(column).c_str() ? std::nan("") : x;
  }
};

struct Table {
  std::vector<std::string> columns;
  std::vector<Row> rows;

  std::vector<const Row*> section(const std::string& name) const {
    std::vector<const Row*> out;
    for (const Row& r : rows)
      if (r.section == name)
        out.push_back(&r);
    EXPECT_FALSE(out.empty()) << "no section " << name;
    return out;
  }
  const Row& row(const std::string& section, const std::string& name) const {
    static const Row none{"", "", std::vector<std::string>(100)};
    for (const Row& r : rows)
      if (r.section == section && r.name == name)
        return r;
    ADD_FAILURE() << "no row " << section << ": " << name;
    return none;
  }
  std::size_t column(const std::string& name) const {
    for (std::size_t i = 0; i < columns.size(); ++i)
      if (columns[i] == name)
        return i;
    ADD_FAILURE() << "no column " << name;
    return 0;
  }
};

/// A run of one paper's command, for all tests of it.
class Paper : public testing::Test {
protected:
  static void run(const std::string& paper) {
    folder_ = fs::temp_directory_path() / ("paper_test_" + paper + std::to_string(getpid()));
    const std::string command = std::string(INSITU_BENCH) + " paper " + paper +
                                " --quick --repetitions 1 --out " + folder_.string() +
                                " > /dev/null";
    exit_ = std::system(command.c_str());
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  void SetUp() override { ASSERT_EQ(exit_, 0); }

  static std::string text_of(const std::string& file) {
    std::ifstream in(folder_ / file);
    std::stringstream s;
    s << in.rdbuf();
    return s.str();
  }
  static Table table(const std::string& key) {
    std::istringstream in(text_of(key + ".csv"));
    std::string line;
    Table out;
    std::getline(in, line);
    const std::vector<std::string> names = insitu::test::split_csv(line);
    EXPECT_GT(names.size(), 2u) << key;
    out.columns.assign(names.begin() + 2, names.end());
    while (std::getline(in, line)) {
      const std::vector<std::string> v = insitu::test::split_csv(line);
      EXPECT_EQ(v.size(), names.size()) << key << ": " << line;
      out.rows.push_back({v[0], v[1], {v.begin() + 2, v.end()}});
    }
    EXPECT_FALSE(out.rows.empty()) << key;
    return out;
  }
  static void expect_positive(const Row& row, std::size_t columns) {
    for (std::size_t c = 0; c < columns; ++c)
      EXPECT_GT(row.at(c), 0.0) << row.section << ": " << row.name << ", column " << c;
  }

  static inline fs::path folder_;
  static inline int exit_ = -1;
};

class Morrical : public Paper {
protected:
  static void SetUpTestSuite() { run("morrical"); }
};

const char* const methods[] = {"cuda-bvh = bvh", "rtx-bvh = user_geometry",
                               "rtx-rep-faces = replicated_faces", "rtx-shrd-faces = shared_faces",
                               "rtx-shrd-bilinear-faces = shared_bilinear_faces"};

TEST_F(Morrical, EveryMethodHasItsRowInEveryTable) {
  for (const char* method : methods) {
    const std::string row = std::string("cpu, ") + method;
    expect_positive(table("morrical-2").row("million a second", row), 6);
    expect_positive(table("morrical-3").row("million a second", row), 6);
    expect_positive(table("morrical-4").row("here", row), 6);
  }
  expect_positive(table("morrical-4").row("here", "cpu, bvh, whole frame"), 6);
  expect_positive(table("morrical-5").row("here", "ours"), 6);
  // The papers' figures stand beside them.
  EXPECT_EQ(table("morrical-2").row("million a second", "paper, Titan RTX, rtx-shrd-faces").at(3),
            2000.0);
  EXPECT_EQ(table("morrical-4").row("paper", "Titan V, cuda-bvh").at(0), 13.98);
  EXPECT_EQ(table("morrical-5").row("paper", "OSPRay").at(5), 1.94);
  EXPECT_EQ(table("morrical-9.4").row("paper, watts", "RTX 8000, triangle methods").at(0), 191.0);
  EXPECT_NEAR(
      table("morrical-2").row("over cuda-bvh = bvh", "paper, Titan RTX, rtx-shrd-faces").at(0),
      537 / 84.5, 1e-6);
}

TEST_F(Morrical, MemoryIsThatOfTheMethodsPrimitives) {
  const Table t = table("morrical-1");
  const Row &ours = t.row("elements", "here"), &papers = t.row("elements", "paper");
  for (std::size_t d = 0; d < 6; ++d) {
    // Four triangles a tetrahedron, eight a wedge, twelve a hexahedron; half of them shared, but
    // those of the boundary.
    const double whole = d < 4 ? 4 : d == 4 ? 8 : 12;
    EXPECT_EQ(t.row(methods[2], "cpu, faces an element").at(d), whole);
    const double shared = t.row(methods[3], "cpu, faces an element").at(d);
    EXPECT_GT(shared, 0.5 * whole);
    EXPECT_LT(shared, 0.75 * whole);
    const double bilinear = t.row(methods[4], "cpu, faces an element").at(d);
    EXPECT_TRUE(d < 4 ? bilinear == shared : bilinear > shared) << d;
    // In the paper's proportions, as far as cubic numbers allow.
    EXPECT_NEAR(ours.at(d) / ours.at(3) * papers.at(3) / papers.at(d), 1.0, 0.4) << d;
    for (const char* method : methods) {
      EXPECT_GE(
          t.row(method, std::string("cpu, peak") + (method == methods[0] ? "" : " (no p/s)")).at(d),
          t.row(method, "cpu, final").at(d));
      if (method != methods[0]) { // these meshes are one group
        EXPECT_TRUE(std::isnan(t.row(method, "cpu, peak (w/ p/s)").at(d))) << method;
      }
    }
    EXPECT_LT(t.row(methods[0], "cpu, final").at(d), t.row(methods[3], "cpu, final").at(d));
  }
  EXPECT_NEAR(t.row(methods[3], "paper, faces an element").at(0), 5.99 / 3, 1e-6);
}

TEST_F(Morrical, NoPointIsLost) {
  const Table t = table("morrical-3");
  for (const Row* row : t.section("points lost (standard)"))
    for (std::size_t d = 0; d < 6; ++d)
      EXPECT_EQ(row->cells[d], "0") << row->name;
}

class Rathke : public Paper {
protected:
  static void SetUpTestSuite() { run("rathke"); }
};

TEST_F(Rathke, TablesHaveThePapersRowsAndColumns) {
  const Table one = table("rathke-1"), two = table("rathke-2"), three = table("rathke-3"),
              four = table("rathke-4");
  for (const char* data : {"Bucky", "Jets", "T-jet", "SF1", "Earthquake"}) {
    expect_positive(one.row("", data), 5);
    expect_positive(four.row("", data), 5);
    // Rays that hit are the same ones whatever the way: of 64 x 64, not all.
    EXPECT_GT(one.row("", data).at(1), 500.0) << data;
    EXPECT_LT(one.row("", data).at(1), 4096.0) << data;
  }
  EXPECT_EQ(one.row("", "Earthquake").at(one.column("packeted")), 46.3);
  EXPECT_NEAR(one.row("", "Bucky").at(one.column("SPMD a core")), 68.9 / 20, 1e-9);
  EXPECT_NEAR(one.row("", "Bucky").at(one.column("packeted a core")), 103.2 / 20, 1e-9);
  EXPECT_EQ(two.columns,
            (std::vector<std::string>{"1", "4", "8", "16", "24", "32", "samples a ray"}));
  EXPECT_EQ(two.section("here").size(), 6u);
  EXPECT_EQ(two.section("paper").size(), 6u);
  EXPECT_EQ(two.row("here", "over groups of 1, mean").at(0), 1.0);
  EXPECT_EQ(four.row("", "SF1").at(four.column("Phi ISO")), 190.8);
}

TEST_F(Rathke, HalfTheStepTakesTwiceTheSamples) {
  const Table t = table("rathke-3");
  for (const char* section : {"here, Jets, tetrahedra", "here, Earthquake, hexahedra"}) {
    const double whole = t.row(section, "1").at(6);
    for (const double step : {0.25, 0.5, 1.5}) {
      std::ostringstream name;
      name << step;
      EXPECT_NEAR(t.row(section, name.str()).at(6) * step / whole, 1.0, 0.05) << section << step;
    }
  }
  EXPECT_EQ(t.row("paper, Jets", "1").at(2), 5.4);
}

class Zellmann : public Paper {
protected:
  static void SetUpTestSuite() { run("zellmann"); }
};

TEST_F(Zellmann, CountsOfTheDualMeshAgree) {
  const Table t = table("zellmann-1");
  for (const char* mesh : {"blocks", "front octree", "random octree"}) {
    const Row& r = t.row("here", mesh);
    const auto at = [&](const char* column) { return r.at(t.column(column)); };
    EXPECT_EQ(at("elems"), at("tets") + at("pyrs") + at("wedges") + at("hexes")) << mesh;
    EXPECT_EQ(at("ref. elems"), at("elems") + at("full cells")) << mesh;
    EXPECT_EQ(at("ref. hexes"), at("hexes") + at("full cells")) << mesh;
    EXPECT_GT(at("pyrs"), 0.0);
    EXPECT_GT(at("full scalars"), at("full cells"));
    // A vertex a leaf at least, and hardly more cells than leaves but for those of the boundary.
    EXPECT_GE(at("ref. verts"), at("leaves")) << mesh;
    // Vertices at one place are one: those beyond a leaf each are the boundary's and the repair's.
    EXPECT_LT(at("ref. verts"), 1.15 * at("leaves")) << mesh;
    EXPECT_NEAR(at("stitching, %"), 100 * at("elems") / at("ref. elems"), 1e-6) << mesh;
    EXPECT_LT(at("ref. elems"), 2.0 * at("leaves")) << mesh;
  }
  EXPECT_EQ(t.section("paper").size(), 4u);
  // Solvers refine about fronts with room between levels: far fewer cells stitch than at random.
  const std::size_t share = t.column("stitching, %");
  EXPECT_LT(t.row("here", "front octree").at(share),
            0.5 * t.row("here", "random octree").at(share));
}

TEST_F(Zellmann, CubesAreCompressed) {
  const Table t = table("zellmann-2");
  for (const Row* r : t.section("here")) {
    EXPECT_NEAR(r->at(0) / r->at(1), r->at(2), 1e-6);
    // Small meshes have small gridlets; 8.3 is what large ones come to.
    EXPECT_GT(r->at(2), 2.0) << r->name;
    EXPECT_LT(r->at(2), 10.0) << r->name;
  }
  EXPECT_EQ(t.row("paper", "NASA Exajet").at(2), 8.1);
  const Table memory = table("zellmann-3");
  for (const Row* r : memory.section("here"))
    for (const std::size_t first : {0, 3}) {
      EXPECT_GE(r->at(first + 1), r->at(first + 2)) << r->name << ": peak, total";
      EXPECT_GE(r->at(first + 2), r->at(first)) << r->name << ": total, data";
    }
  EXPECT_NEAR(memory.row("paper", "LANL Impact").at(0), 12.8 * 1073741824 / 289e6, 1e-6);
}

TEST_F(Zellmann, GridletsDrawWhatHexahedraDo) {
  const Table t = table("zellmann-4");
  for (const Row* r : t.section("here")) {
    EXPECT_GT(r->at(t.column("Ref.")), 0.0);
    EXPECT_GT(r->at(t.column("Ours")), 0.0);
    // Ray-marched, at the same samples: floats' rounding alone.
    EXPECT_LT(r->at(t.column("difference")), 1e-6) << r->name;
  }
}

TEST_F(Zellmann, EveryLevelAddsLeavesAndSamplesAddUp) {
  const Table six = table("zellmann-6");
  for (const char* mesh : {"blocks", "front octree", "random octree"}) {
    double leaves = 0.0;
    for (const Row* r : six.section(mesh)) {
      EXPECT_GT(r->at(0), leaves) << mesh << ' ' << r->name;
      EXPECT_GT(r->at(2), 0.0);
      leaves = r->at(0);
    }
    const Table one = table("zellmann-1");
    EXPECT_EQ(leaves, one.row("here", mesh).at(0)) << mesh;
  }
  for (const char* mesh : {"blocks", "front", "octree"}) {
    const Table seven = table(std::string("zellmann-7-") + mesh);
    EXPECT_EQ(seven.section("here").size(), 4u);
    for (const Row* r : seven.section("here")) {
      EXPECT_EQ(r->at(0) + r->at(1) + r->at(2), r->at(3)) << mesh << ", view " << r->name;
      EXPECT_GT(r->at(0), 0.0);
      EXPECT_GT(r->at(1), 0.0);
      EXPECT_EQ(r->at(2), 0.0) << "the cells cover the box";
    }
    EXPECT_NE(text_of(std::string("zellmann-7-") + mesh + ".svg").find("<svg"), std::string::npos);
    const Table eight = table(std::string("zellmann-8-") + mesh);
    for (const Row* r : eight.section("here")) {
      const auto at = [&](const char* column) { return r->at(eight.column(column)); };
      EXPECT_GT(at("in stitching"), 0.0) << mesh;
      EXPECT_LT(at("in stitching"), at("samples")) << mesh;
      for (const char* timed : {"planar ns", "bilinear ns", "by rays: planar"})
        EXPECT_GT(at(timed), 0.0) << mesh;
      // The planar test errs, but in few places, and by less than the field's range.
      EXPECT_GT(at("other cell"), 0.0) << mesh;
      EXPECT_LT(at("other cell"), 0.1 * at("samples")) << mesh;
      EXPECT_GT(at("largest"), 0.0) << mesh;
      EXPECT_LT(at("largest"), 0.5) << mesh;
      EXPECT_LE(at("value, rms"), at("largest")) << mesh;
      EXPECT_LT(at("image"), 0.01) << mesh;
    }
  }
}

} // namespace
