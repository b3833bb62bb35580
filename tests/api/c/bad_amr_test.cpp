/// Adaptive meshes that cannot be, are at a limit, or change without a commit.
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>

#include "bad_input.h"

using namespace bad_input;

namespace {

/// A session with an adaptive mesh of unit cubes at level 0.
struct Adaptive : testing::Test {
  insitu_session session = nullptr;
  insitu_mesh mesh = nullptr;

  void SetUp() override { open(); }
  void TearDown() override { EXPECT_EQ(insitu_session_close(&session), INSITU_OK); }
  void open() {
    insitu_session_options options = insitu_session_options_default();
    options.threads = 2;
    options.log_level = INSITU_LOG_ERROR;
    ASSERT_EQ(insitu_session_open(&options, &session), INSITU_OK);
    ASSERT_EQ(insitu_session_mesh(session, "amr", &mesh), INSITU_OK);
  }
  void levels(int count) {
    insitu_amr amr = insitu_amr_default();
    amr.level_count = count;
    ASSERT_EQ(insitu_mesh_amr(mesh, &amr), INSITU_OK) << message();
  }
  /// n^3 cells of a level, whose values lie in `rho`.
  void patch(std::int32_t piece, int level, std::int64_t lower, std::int64_t n,
             const std::vector<double>& rho) {
    insitu_patch p = insitu_patch_default();
    p.level = level;
    for (int a = 0; a < 3; ++a) {
      p.lower[a] = lower;
      p.cells[a] = n;
    }
    ASSERT_EQ(insitu_mesh_patch(mesh, piece, &p), INSITU_OK) << message();
    const insitu_array a = insitu_array_of(rho.data(), INSITU_FLOAT64, n * n * n, 1);
    ASSERT_EQ(insitu_mesh_field(mesh, piece, "rho", INSITU_CELL, &a, 1), INSITU_OK) << message();
  }
  insitu_status commit() const { return insitu_mesh_commit(mesh, nullptr); }
  /// The value at (x, x, x); nothing outside.
  std::pair<double, bool> at(double x) const {
    const double point[3] = {x, x, x};
    double value = 0.0;
    std::int32_t found = 0;
    EXPECT_EQ(insitu_mesh_sample_point(mesh, "rho", point, &value, &found), INSITU_OK) << message();
    return {value, found != 0};
  }
};

const std::vector<double> ones(64, 1.0), twos(64, 2.0), threes(64, 3.0);

} // namespace

TEST_F(Adaptive, PatchesThatOverlapOrStandAskewAreRefusedByName) {
  levels(2);
  patch(0, 0, 0, 3, ones);
  patch(1, 0, 2, 2, twos);
  EXPECT_REFUSED(commit(), INSITU_ERROR_MESH, "'amr'", "piece 0", "piece 1");
  patch(1, 1, 1, 2, twos); // from the middle of a coarse cell to the middle of the next
  EXPECT_REFUSED(commit(), INSITU_ERROR_MESH, "'amr'", "piece");
  patch(1, 1, 2, 2, twos);
  EXPECT_EQ(commit(), INSITU_OK) << message();
}

TEST_F(Adaptive, ASingleCellASingleLevelAndALevelLeftOut) {
  levels(1);
  patch(0, 0, 0, 1, threes);
  ASSERT_EQ(commit(), INSITU_OK) << message();
  EXPECT_DOUBLE_EQ(at(0.5).first, 3.0);
  EXPECT_DOUBLE_EQ(at(0.1).first, 3.0);
  EXPECT_FALSE(at(1.1).second);
  patch(0, 0, 0, 3, threes);
  ASSERT_EQ(commit(), INSITU_OK) << message();
  EXPECT_DOUBLE_EQ(at(1.7).first, 3.0);
  levels(3); // none of level 1
  patch(1, 2, 4, 4, twos);
  ASSERT_EQ(commit(), INSITU_OK) << message();
  EXPECT_DOUBLE_EQ(at(1.375).first, 2.0);
  EXPECT_DOUBLE_EQ(at(0.5).first, 3.0);
  EXPECT_DOUBLE_EQ(at(2.5).first, 3.0);
}

TEST_F(Adaptive, NoLeavesIsNowhere) {
  levels(4);
  insitu_leaves none = insitu_leaves_default();
  none.levels = insitu_array_of(nullptr, INSITU_UINT8, 0, 1);
  none.corners = insitu_array_of(nullptr, INSITU_INT32, 0, 3);
  ASSERT_EQ(insitu_mesh_leaves(mesh, 0, &none), INSITU_OK) << message();
  const insitu_array nothing = insitu_array_of(nullptr, INSITU_FLOAT64, 0, 1);
  ASSERT_EQ(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &nothing, 1), INSITU_OK) << message();
  ASSERT_EQ(commit(), INSITU_OK) << message();
  EXPECT_FALSE(at(0.5).second);
  EXPECT_EQ(insitu_session_execute(session, 0, 0.0), INSITU_OK) << message();
}

TEST_F(Adaptive, CellsThatAreNoNumbersSpoilTheirNeighboursAlone) {
  levels(1);
  std::vector<double> rho(64, 1.0);
  rho[0] = std::numeric_limits<double>::quiet_NaN();
  patch(0, 0, 0, 4, rho);
  ASSERT_EQ(commit(), INSITU_OK) << message();
  EXPECT_TRUE(std::isnan(at(0.6).first));
  EXPECT_DOUBLE_EQ(at(2.2).first, 1.0);
  EXPECT_TRUE(at(0.6).second);
}

/// In a checked session.
struct CheckedAdaptive : Adaptive {
  void SetUp() override {
    setenv("INSITU_CHECKED", "1", 1);
    open();
    unsetenv("INSITU_CHECKED");
  }
};

/// Leaves of a level each, all in one array of records.
struct Leaves {
  struct Record {
    std::int32_t corner[3];
    std::uint8_t level;
  };
  std::vector<Record> records;
  std::vector<double> values;
  /// The cells of level 1 in `side` unit cells along each axis.
  explicit Leaves(std::int32_t side) {
    for (std::int32_t k = 0; k < 2 * side; ++k)
      for (std::int32_t j = 0; j < 2 * side; ++j)
        for (std::int32_t i = 0; i < 2 * side; ++i)
          records.push_back({{i, j, k}, 1});
    values.assign(records.size(), 1.0);
  }
  insitu_leaves view() const {
    insitu_leaves l = insitu_leaves_default();
    const auto n = std::int64_t(records.size());
    l.levels = insitu_array_of(&records[0].level, INSITU_UINT8, n, 1);
    l.corners = insitu_array_of(records[0].corner, INSITU_INT32, n, 3);
    l.levels.stride[0] = l.corners.stride[0] = sizeof(Record);
    return l;
  }
};

/// In a commit that says that nothing but values changed; the session goes on.
TEST_F(CheckedAdaptive, ARegridOfLeavesThatWasNotAnnouncedIsFoundOut) {
  Leaves leaves(2);
  levels(3);
  insitu_leaves l = leaves.view();
  l.offset[2] = -3;
  ASSERT_EQ(insitu_mesh_leaves(mesh, 0, &l), INSITU_OK) << message();
  insitu_array a = insitu_array_of(leaves.values.data(), INSITU_FLOAT64, 64, 1);
  ASSERT_EQ(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1), INSITU_OK);
  ASSERT_EQ(commit(), INSITU_OK) << message();
  ASSERT_EQ(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS), INSITU_OK);
  EXPECT_EQ(commit(), INSITU_OK) << message();

  const Leaves before = leaves;
  leaves.records[37].level = 2;
  leaves.records[50].level = 2; // the first one is named
  ASSERT_EQ(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS), INSITU_OK);
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "'amr'", "piece 0, leaf 37",
                 "was level 1, corner (1, 1, 2)", "now level 2, corner (1, 1, 2)",
                 "INSITU_CHANGED_TOPOLOGY", "insitu_mesh_changed");
  leaves.records = before.records;
  EXPECT_EQ(commit(), INSITU_OK) << message();

  std::swap(leaves.records[2], leaves.records[3]); // the same cells, of other values
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "leaf 2: was level 1, corner (2, 0, 0)",
                 "now level 1, corner (3, 0, 0)");
  const double point[3] = {0.5, 0.5, -1.0};
  double value = 0.0;
  EXPECT_REFUSED(insitu_mesh_sample_point(mesh, "rho", point, &value, nullptr), INSITU_ERROR_ORDER,
                 "leaf 2");
  leaves.records[2].level = 200; // what freed memory might hold
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "leaf 2", "now level");
  leaves.records = before.records;

  // Announced: the corner leaf's eight children.
  leaves.records[0] = {{0, 0, 0}, 2};
  for (std::int32_t child = 1; child < 8; ++child)
    leaves.records.push_back({{child & 1, child >> 1 & 1, child >> 2}, 2});
  leaves.values.assign(leaves.records.size(), 2.0);
  for (Leaves::Record& r : leaves.records)
    r.corner[2] += r.level == 2 ? -3 : 0; // twice the offset of -3 half as large cells
  l = leaves.view();
  l.offset[2] = -3;
  ASSERT_EQ(insitu_mesh_leaves(mesh, 0, &l), INSITU_OK) << message();
  a = insitu_array_of(leaves.values.data(), INSITU_FLOAT64, 71, 1);
  ASSERT_EQ(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1), INSITU_OK);
  ASSERT_EQ(commit(), INSITU_OK) << message();
  std::int32_t found = 0;
  ASSERT_EQ(insitu_mesh_sample_point(mesh, "rho", point, &value, &found), INSITU_OK) << message();
  EXPECT_TRUE(found);
  EXPECT_DOUBLE_EQ(value, 2.0);
  leaves.records[70].corner[0] = 9;
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "leaf 70: was level 2, corner (1, 1, -2)",
                 "now level 2, corner (9, 1, -2)");
}

TEST_F(CheckedAdaptive, CornersInFinerCellsAreNamedAsTheSolverStoresThem) {
  std::vector<Leaves::Record> records{{{0, 0, 0}, 1}, {{1 << 18, 0, 0}, 1}};
  std::vector<const void*> pointers{&records[0], &records[1]}; // of records behind pointers
  levels(2);
  insitu_leaves l = insitu_leaves_default();
  l.levels = insitu_array_of(pointers.data(), INSITU_UINT8, 2, 1);
  l.corners = insitu_array_of(pointers.data(), INSITU_INT32, 2, 3);
  l.levels.indirect = l.corners.indirect = 1;
  l.levels.offset = offsetof(Leaves::Record, level);
  l.corner_bits = 19;
  ASSERT_EQ(insitu_mesh_leaves(mesh, 0, &l), INSITU_OK) << message();
  const insitu_array a = insitu_array_of(ones.data(), INSITU_FLOAT64, 2, 1);
  ASSERT_EQ(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1), INSITU_OK);
  ASSERT_EQ(commit(), INSITU_OK) << message();
  records[1].corner[1] = 1 << 18;
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "leaf 1: was level 1, corner (262144, 0, 0)",
                 "now level 1, corner (262144, 262144, 0)");
  pointers[0] = nullptr;
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "leaf 0: was level 1", "its pointer is null");
  pointers[0] = &records[0];
  ASSERT_EQ(insitu_mesh_changed(mesh, INSITU_CHANGED_TOPOLOGY), INSITU_OK);
  EXPECT_EQ(commit(), INSITU_OK) << message();
  EXPECT_EQ(commit(), INSITU_OK) << message();
}

/// Patches cannot move without a word, since they are given by number; but their fields can be
/// given as if they had.
TEST_F(CheckedAdaptive, ARegridOfPatchesThatWasNotAnnouncedIsFoundOut) {
  levels(2);
  patch(0, 0, 0, 4, ones);
  insitu_patch fine = insitu_patch_default();
  fine.level = 1;
  for (int a = 0; a < 3; ++a) {
    fine.lower[a] = 2;
    fine.cells[a] = a == 2 ? 2 : 4;
  }
  ASSERT_EQ(insitu_mesh_patch(mesh, 1, &fine), INSITU_OK) << message();
  const auto give = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    insitu_array a = insitu_array_of(twos.data(), INSITU_FLOAT64, i * j * k, 1);
    a.extent[0] = i;
    a.extent[1] = j;
    a.extent[2] = k;
    EXPECT_EQ(insitu_mesh_field(mesh, 1, "rho", INSITU_CELL, &a, 1), INSITU_OK) << message();
  };
  give(4, 4, 2);
  ASSERT_EQ(commit(), INSITU_OK) << message();
  give(4, 4, 2); // in another place, or with new values
  EXPECT_EQ(commit(), INSITU_OK) << message();
  give(2, 4, 4);
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "'amr'", "piece 1",
                 "patch of cells (2, 2, 2) to (5, 5, 3)",
                 "field 'rho' was 4 x 4 x 2 items, now 2 x 4 x 4", "INSITU_CHANGED_TOPOLOGY");
  give(4, 4, 4);
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "now 4 x 4 x 4");
  give(64, 1, 1); // a list: of another number
  EXPECT_REFUSED(commit(), INSITU_ERROR_FIELD, "64 values for 32 cells of the patch",
                 "insitu_mesh_patch");
  give(2, 4, 4);
  fine.cells[0] = 2;
  fine.cells[2] = 4;
  ASSERT_EQ(insitu_mesh_patch(mesh, 1, &fine), INSITU_OK) << message();
  ASSERT_EQ(commit(), INSITU_OK) << message();
  EXPECT_DOUBLE_EQ(at(1.25).first, 2.0);
  ASSERT_EQ(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS), INSITU_OK);
  EXPECT_EQ(commit(), INSITU_OK) << message();
  // A piece that only its field tells of.
  const insitu_array more = insitu_array_of(ones.data(), INSITU_FLOAT64, 8, 1);
  ASSERT_EQ(insitu_mesh_field(mesh, 2, "rho", INSITU_CELL, &more, 1), INSITU_OK) << message();
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "piece 2", "insitu_mesh_patch");
  ASSERT_EQ(insitu_mesh_drop_pieces(mesh, 2), INSITU_OK) << message();
  EXPECT_EQ(commit(), INSITU_OK) << message();
}

/// What is not checked costs nothing: the same without.
TEST_F(Adaptive, UncheckedSessionsKeepNoCopyOfLeaves) {
  const auto bytes = [&](bool checked) {
    EXPECT_EQ(insitu_session_close(&session), INSITU_OK);
    setenv("INSITU_CHECKED", checked ? "1" : "0", 1);
    open();
    unsetenv("INSITU_CHECKED");
    const Leaves leaves(8);
    levels(2);
    const insitu_leaves l = leaves.view();
    EXPECT_EQ(insitu_mesh_leaves(mesh, 0, &l), INSITU_OK) << message();
    const insitu_array a = insitu_array_of(leaves.values.data(), INSITU_FLOAT64,
                                           std::int64_t(leaves.values.size()), 1);
    EXPECT_EQ(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1), INSITU_OK) << message();
    EXPECT_EQ(commit(), INSITU_OK) << message();
    insitu_report report = insitu_report_default();
    EXPECT_EQ(insitu_session_report(session, &report), INSITU_OK) << message();
    return report.bytes_held;
  };
  const std::int64_t unchecked = bytes(false);
  EXPECT_EQ(bytes(true) - unchecked, 16 * 4096);
}
