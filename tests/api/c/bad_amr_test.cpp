/// Adaptive meshes that cannot be, are at a limit, or change without a commit.
#include <array>
#include <cmath>
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

TEST_F(CheckedAdaptive, ARegridThatWasNotAnnouncedIsFoundOut) {
  std::array<std::uint8_t, 8> level;
  level.fill(1);
  std::array<std::array<std::int32_t, 3>, 8> corner;
  for (int i = 0; i < 8; ++i)
    corner[std::size_t(i)] = {i & 1, i >> 1 & 1, i >> 2};
  levels(3);
  insitu_leaves l = insitu_leaves_default();
  l.levels = insitu_array_of(level.data(), INSITU_UINT8, 8, 1);
  l.corners = insitu_array_of(corner.data(), INSITU_INT32, 8, 3);
  ASSERT_EQ(insitu_mesh_leaves(mesh, 0, &l), INSITU_OK) << message();
  const insitu_array a = insitu_array_of(ones.data(), INSITU_FLOAT64, 8, 1);
  ASSERT_EQ(insitu_mesh_field(mesh, 0, "rho", INSITU_CELL, &a, 1), INSITU_OK);
  ASSERT_EQ(commit(), INSITU_OK) << message();
  level[5] = 2;
  ASSERT_EQ(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS), INSITU_OK);
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "'amr'", "piece 0 levels", "items 0 to 7",
                 "insitu_mesh_changed");
  level[5] = 1;
  corner[2][1] = 7;
  EXPECT_REFUSED(commit(), INSITU_ERROR_ORDER, "piece 0 corners");
  ASSERT_EQ(insitu_mesh_changed(mesh, INSITU_CHANGED_TOPOLOGY), INSITU_OK);
  EXPECT_EQ(commit(), INSITU_OK) << message();
}
