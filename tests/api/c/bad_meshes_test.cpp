/// Meshes that are too large, or that change without a commit.
#include <chrono>
#include <cstdlib>

#include "bad_input.h"

using namespace bad_input;

TEST(BadMeshes, AMeshOfTooManyCellsIsRefusedBeforeAnyWork) {
  Box box;
  insitu_mesh mesh = nullptr;
  ASSERT_EQ(insitu_session_mesh(box.session, "huge", &mesh), INSITU_OK);
  insitu_block block = insitu_block_default();
  block.kind = INSITU_BLOCK_UNIFORM;
  const auto give = [&](std::int32_t piece, std::int64_t i, std::int64_t j, std::int64_t k) {
    block.vertices[0] = i + 1;
    block.vertices[1] = j + 1;
    block.vertices[2] = k + 1;
    ASSERT_EQ(insitu_mesh_block(mesh, piece, &block), INSITU_OK) << message();
  };
  const auto begin = std::chrono::steady_clock::now();
  give(0, 1 << 16, 1 << 16, 1); // one more than 32 bits count
  EXPECT_REFUSED(insitu_mesh_commit(mesh, nullptr), INSITU_ERROR_UNSUPPORTED, "'huge'",
                 "4294967296 cells", "at most 4294967295");
  insitu_validation validation = insitu_validation_default();
  EXPECT_REFUSED(insitu_mesh_validate(mesh, &validation), INSITU_ERROR_UNSUPPORTED,
                 "4294967296 cells");
  EXPECT_REFUSED(insitu_session_execute(box.session, 0, 0.0), INSITU_ERROR_UNSUPPORTED, "'huge'");
  const std::int64_t most = (1 << 20) - 1;
  give(0, most, most, most);
  EXPECT_REFUSED(insitu_mesh_commit(mesh, nullptr), INSITU_ERROR_UNSUPPORTED,
                 "1152918206075109375 cells");
  // Pieces whose sum would overflow 64 bits; the first fits.
  give(0, 2, 2, 2);
  for (std::int32_t p = 1; p < 20; ++p)
    give(p, most, most, most);
  EXPECT_REFUSED(insitu_mesh_commit(mesh, nullptr), INSITU_ERROR_UNSUPPORTED, "piece 1",
                 "after the 8 of the pieces before");
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(elapsed.count(), 1.0); // any pass over the cells takes many times that
  // The others of the session work on.
  const double p[3] = {0.5, 0.5, 0.5};
  double value = 0;
  std::int32_t found = 0;
  EXPECT_EQ(insitu_mesh_sample_point(box.mesh, "pressure", p, &value, &found), INSITU_OK);
  EXPECT_EQ(found, 1);
}

/// Cells with ids beyond 2^31, all ghosts but the last few. A minute; not run by itself.
TEST(BadMeshes, DISABLED_IdsBeyondTwoToThe31) {
  constexpr std::int64_t n = 1300, cells = n * n * n;
  static_assert(cells > (std::int64_t(1) << 31));
  insitu_session session = nullptr;
  insitu_mesh mesh = nullptr;
  insitu_session_options options = insitu_session_options_default();
  // The other builder needs room for all cells while it builds.
  options.scene_text = "insitu: 1\nlocator: {builder: surface_area}\n";
  ASSERT_EQ(insitu_session_open(&options, &session), INSITU_OK) << message();
  ASSERT_EQ(insitu_session_mesh(session, "large", &mesh), INSITU_OK);
  insitu_block block = insitu_block_default();
  block.kind = INSITU_BLOCK_UNIFORM;
  for (std::int64_t& v : block.vertices)
    v = n + 1;
  ASSERT_EQ(insitu_mesh_block(mesh, 0, &block), INSITU_OK);
  // Ghost bits by i + j + k alone, so that they cost nothing: the far corner owns.
  std::vector<std::uint8_t> bits(3 * n, 1);
  for (std::size_t sum = 3 * (n - 1) - 3; sum < bits.size(); ++sum)
    bits[sum] = 0;
  insitu_array ghosts = insitu_array_of(bits.data(), INSITU_UINT8, 0, 1);
  for (int a = 0; a < 3; ++a) {
    ghosts.extent[a] = n;
    ghosts.stride[a] = 1;
  }
  ASSERT_EQ(insitu_mesh_ghosts(mesh, 0, &ghosts, INSITU_GHOSTS_VTK), INSITU_OK) << message();
  ASSERT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << message();
  const double xyz[] = {n - 0.5, n - 0.5, n - 0.5, n - 1.5, n - 0.5, n - 1.5, 0.5, 0.5, 0.5};
  const insitu_array points = insitu_array_of(xyz, INSITU_FLOAT64, 3, 3);
  std::int64_t owner[3];
  insitu_locate_args args = insitu_locate_args_default();
  args.points = &points;
  args.cells = owner;
  ASSERT_EQ(insitu_mesh_locate(mesh, &args), INSITU_OK) << message();
  EXPECT_EQ(owner[0], cells - 1);
  EXPECT_EQ(owner[1], n - 2 + n * (n - 1 + n * (n - 2)));
  EXPECT_EQ(owner[2], -1);
  EXPECT_EQ(insitu_session_close(&session), INSITU_OK);
}

/// The checked build's answer to a mesh that was changed without a commit; here by the environment.
struct Checked : testing::Test {
  Checked() { setenv("INSITU_CHECKED", "1", 1); }
  ~Checked() override { unsetenv("INSITU_CHECKED"); }

  static insitu_status locate(const Box& box) {
    static const double xyz[] = {0.5, 0.5, 0.5};
    const insitu_array points = insitu_array_of(xyz, INSITU_FLOAT64, 1, 3);
    insitu_locate_args args = insitu_locate_args_default();
    args.points = &points;
    return insitu_mesh_locate(box.mesh, &args);
  }
  static insitu_status sample_point(const Box& box) {
    const double p[3] = {0.5, 0.5, 0.5};
    double value = 0;
    return insitu_mesh_sample_point(box.mesh, "pressure", p, &value, nullptr);
  }
  /// The commit is refused while only `other` is said to have changed, and not once `what` is too.
  static void expect_good_only_after(const Box& box, std::uint32_t other, std::uint32_t what,
                                     const char* array) {
    EXPECT_EQ(insitu_mesh_changed(box.mesh, other), INSITU_OK);
    EXPECT_REFUSED(insitu_mesh_commit(box.mesh, nullptr), INSITU_ERROR_ORDER, array);
    EXPECT_EQ(insitu_mesh_changed(box.mesh, what), INSITU_OK);
    EXPECT_EQ(insitu_mesh_commit(box.mesh, nullptr), INSITU_OK) << message();
    EXPECT_EQ(locate(box), INSITU_OK) << message();
  }
};

TEST_F(Checked, AVertexThatMovedIsFoundOut) {
  Box box;
  EXPECT_EQ(locate(box), INSITU_OK) << message();
  EXPECT_EQ(sample_point(box), INSITU_OK) << message();
  box.xyz.back() += 1e-12;
  EXPECT_REFUSED(locate(box), INSITU_ERROR_ORDER, "mesh 'box'", "piece 0 points",
                 "insitu_mesh_changed");
  EXPECT_REFUSED(sample_point(box), INSITU_ERROR_ORDER, "piece 0 points");
  // Saying nothing, or that it was the fields, does not make it good.
  EXPECT_REFUSED(insitu_mesh_commit(box.mesh, nullptr), INSITU_ERROR_ORDER, "piece 0 points");
  EXPECT_REFUSED(insitu_session_execute(box.session, 0, 0.0), INSITU_ERROR_ORDER, "piece 0 points");
  expect_good_only_after(box, INSITU_CHANGED_FIELDS, INSITU_CHANGED_GEOMETRY, "piece 0 points");
}

TEST_F(Checked, AConnectivityThatChangedIsFoundOut) {
  Box box;
  std::swap(box.connectivity[8 * 20 + 1], box.connectivity[8 * 20 + 3]);
  EXPECT_REFUSED(locate(box), INSITU_ERROR_ORDER, "piece 0 connectivity", "items 0 to 23");
  expect_good_only_after(box, INSITU_CHANGED_GEOMETRY, INSITU_CHANGED_TOPOLOGY,
                         "piece 0 connectivity");
}

TEST_F(Checked, ArraysGivenAnewAndFieldsAreNoChange) {
  Box box;
  box.pressure[0] = -7.0; // fields are read as they are
  EXPECT_EQ(locate(box), INSITU_OK) << message();
  {
    std::vector<double> moved = box.xyz;
    moved[0] -= 0.5;
    insitu_array a =
        insitu_array_of(moved.data(), INSITU_FLOAT64, std::int64_t(box.pressure.size()), 3);
    ASSERT_EQ(insitu_mesh_points(box.mesh, 0, &a, 1), INSITU_OK);
    ASSERT_EQ(insitu_mesh_commit(box.mesh, nullptr), INSITU_OK) << message();
    EXPECT_EQ(locate(box), INSITU_OK) << message();
    a.data = box.xyz.data();
    ASSERT_EQ(insitu_mesh_points(box.mesh, 0, &a, 1), INSITU_OK);
  } // the arrays of the last commit are gone, and nothing looks at them again
  ASSERT_EQ(insitu_mesh_commit(box.mesh, nullptr), INSITU_OK) << message();
  EXPECT_EQ(locate(box), INSITU_OK) << message();
}

TEST(Unchecked, AMeshThatChangedIsAnsweredAsItIs) {
  setenv("INSITU_CHECKED", "0", 1);
  {
    Box box;
    box.xyz[0] += 1e-12;
    EXPECT_EQ(Checked::locate(box), INSITU_OK) << message();
  }
  unsetenv("INSITU_CHECKED");
}
