/// The choice of a locator through the C API and scenes: the same owners by every method, and what
/// cannot be had is said.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

#include "insitu/insitu.h"

#include "workload/mesh.h"
#include "workload/queries.h"

using namespace insitu;

namespace {

#define REQUIRE_OK(call) ASSERT_EQ(call, INSITU_OK) << insitu_last_message()

std::string message() {
  return insitu_last_message();
}

class Locators : public testing::Test {
protected:
  void SetUp() override {
    mesh_ = workload::make_box(workload::Kind::mixed, 8, 0.2);
    field_ = workload::vertex_field(mesh_);
    using workload::Pattern;
    for (const auto pattern : {Pattern::random, Pattern::vertices, Pattern::edges, Pattern::faces})
      for (const math::Vec3d& p : workload::make_queries(mesh_, pattern, 500).points)
        points_.insert(points_.end(), {p.x, p.y, p.z});
    points_.insert(points_.end(), {-1.0, 0.5, 0.5});
    open(nullptr);
  }
  void TearDown() override { insitu_session_close(&session_); }

  void open(const char* scene) {
    insitu_session_close(&session_);
    log_.clear();
    insitu_session_options options = insitu_session_options_default();
    options.scene_text = scene;
    options.log_user = &log_;
    options.log = [](insitu_log_level, const char* text, void* user) {
      static_cast<std::string*>(user)->append(text).append("\n");
    };
    REQUIRE_OK(insitu_session_open(&options, &session_));
    REQUIRE_OK(insitu_session_mesh(session_, "m", &handle_));
    insitu_array a = insitu_array_of(mesh_.points.data(), INSITU_FLOAT64, mesh_.vertex_count(), 3);
    REQUIRE_OK(insitu_mesh_points(handle_, 0, &a, 1));
    insitu_cells cells = insitu_cells_default();
    cells.layout = INSITU_LAYOUT_MIXED;
    cells.count = mesh_.cell_count();
    cells.types = insitu_array_of(mesh_.types.data(), INSITU_UINT8, cells.count, 1);
    cells.offsets = insitu_array_of(mesh_.offsets.data(), INSITU_INT64, cells.count + 1, 1);
    cells.connectivity = insitu_array_of(mesh_.connectivity.data(), INSITU_INT32,
                                         std::int64_t(mesh_.connectivity.size()), 1);
    REQUIRE_OK(insitu_mesh_cells(handle_, 0, &cells));
    a = insitu_array_of(field_.data(), INSITU_FLOAT64, mesh_.vertex_count(), 1);
    REQUIRE_OK(insitu_mesh_field(handle_, 0, "f", INSITU_VERTEX, &a, 1));
  }

  insitu_status choose(insitu_method method, insitu_backend backend) {
    insitu_locator l = insitu_locator_default();
    l.method = method;
    l.backend = backend;
    return insitu_mesh_locator(handle_, &l);
  }

  std::vector<std::int64_t> owners(insitu_accuracy accuracy = INSITU_EXACT) {
    const auto n = std::int64_t(points_.size() / 3);
    std::vector<std::int64_t> cells(static_cast<std::size_t>(n));
    const insitu_array points = insitu_array_of(points_.data(), INSITU_FLOAT64, n, 3);
    insitu_locate_args args = insitu_locate_args_default();
    args.points = &points;
    args.accuracy = accuracy;
    args.cells = cells.data();
    EXPECT_EQ(insitu_mesh_locate(handle_, &args), INSITU_OK) << message();
    return cells;
  }

  insitu_locator_info info() {
    insitu_locator_info i = insitu_locator_info_default();
    EXPECT_EQ(insitu_mesh_locator_info(handle_, &i), INSITU_OK) << message();
    return i;
  }

  workload::Mesh mesh_;
  std::vector<double> field_, points_;
  insitu_session session_ = nullptr;
  insitu_mesh handle_ = nullptr;
  std::string log_;
};

constexpr insitu_method ray_methods[] = {INSITU_METHOD_USER_GEOMETRY,
                                         INSITU_METHOD_REPLICATED_FACES, INSITU_METHOD_SHARED_FACES,
                                         INSITU_METHOD_SHARED_BILINEAR_FACES};

/// Of the 500 random points; the others are on boundaries, where nothing is certified. Flat
/// triangles lose 2 to 3 % of them in this mesh.
constexpr std::int64_t least_kept = 460;

} // namespace

TEST_F(Locators, EveryMethodGivesTheSameOwners) {
  REQUIRE_OK(insitu_mesh_commit(handle_, nullptr));
  const std::vector<std::int64_t> expected = owners();
  EXPECT_EQ(info().method, INSITU_METHOD_BVH);
  EXPECT_EQ(info().backend, INSITU_BACKEND_CPU);
  const std::int64_t of_tree = info().bytes;
  for (const insitu_method method : ray_methods) {
    REQUIRE_OK(choose(method, INSITU_BACKEND_CPU));
    REQUIRE_OK(insitu_mesh_commit(handle_, nullptr));
    const insitu_locator_info before = info();
    EXPECT_EQ(before.method, method);
    EXPECT_STREQ(before.reason, "as asked for");
    EXPECT_GT(before.bytes, of_tree);
    EXPECT_GE(before.bytes_peak, before.bytes);
    EXPECT_EQ(owners(), expected) << "method " << method;
    EXPECT_EQ(owners(INSITU_STANDARD), expected) << "method " << method;
    const insitu_locator_info after = info();
    EXPECT_EQ(after.kept + after.by_neighbour + after.by_tree - before.kept - before.by_neighbour -
                  before.by_tree,
              std::int64_t(2 * expected.size()));
    EXPECT_GT(after.kept - before.kept, 2 * least_kept) << "method " << method;
  }
}

TEST_F(Locators, FollowMovedVertices) {
  for (const insitu_method method : ray_methods) {
    REQUIRE_OK(choose(method, INSITU_BACKEND_CPU));
    REQUIRE_OK(insitu_mesh_commit(handle_, nullptr));
    for (std::size_t i = 0; i < mesh_.points.size(); i += 3)
      mesh_.points[i] += 0.25 * mesh_.points[i + 1]; // a shear
    REQUIRE_OK(insitu_mesh_changed(handle_, INSITU_CHANGED_GEOMETRY));
    insitu_commit_report report = insitu_commit_report_default();
    REQUIRE_OK(insitu_mesh_commit(handle_, &report));
    EXPECT_EQ(report.action, INSITU_REFIT);
    const std::int64_t kept = info().kept;
    const std::vector<std::int64_t> got = owners();
    EXPECT_GT(info().kept - kept, least_kept) << "method " << method;
    REQUIRE_OK(choose(INSITU_METHOD_BVH, INSITU_BACKEND_CPU));
    REQUIRE_OK(insitu_mesh_commit(handle_, nullptr));
    EXPECT_EQ(got, owners()) << "method " << method;
  }
}

TEST_F(Locators, TheSummaryHasTheFallbacks) {
  REQUIRE_OK(choose(INSITU_METHOD_SHARED_FACES, INSITU_BACKEND_CPU));
  REQUIRE_OK(insitu_mesh_commit(handle_, nullptr));
  owners();
  const insitu_locator_info i = info();
  owners(INSITU_FAST); // proves nothing, and is not counted
  EXPECT_EQ(info().kept, i.kept);
  EXPECT_EQ(info().by_tree, i.by_tree);
  EXPECT_GT(i.by_neighbour, 0); // bent quads
  const std::string path =
      testing::TempDir() + "locators_summary_" + std::to_string(getpid()) + ".json";
  REQUIRE_OK(insitu_session_write_summary(session_, path.c_str(), -1.0));
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  std::filesystem::remove(path);
  const std::string wanted = "\"located_by_locators\": {\n    \"kept\": " + std::to_string(i.kept) +
                             ",\n    \"by_neighbour\": " + std::to_string(i.by_neighbour) +
                             ",\n    \"by_tree\": " + std::to_string(i.by_tree) +
                             ",\n    \"settled_on_host\": 0\n  }";
  EXPECT_NE(text.str().find(wanted), std::string::npos) << text.str();
}

TEST_F(Locators, BadChoices) {
  EXPECT_EQ(choose(insitu_method(99), INSITU_BACKEND_AUTO), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(message(), "locator: unknown method 99");
  EXPECT_EQ(choose(INSITU_METHOD_AUTO, insitu_backend(-1)), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(message(), "locator: unknown backend -1");
  EXPECT_EQ(choose(INSITU_METHOD_SHARED_FACES, INSITU_BACKEND_CUDA), INSITU_ERROR_UNSUPPORTED);
  EXPECT_EQ(message(),
            "locator: method shared_faces is not on backend cuda; cpu and optix have it");
  EXPECT_EQ(choose(INSITU_METHOD_BVH, INSITU_BACKEND_OPTIX), INSITU_ERROR_UNSUPPORTED);
  insitu_locator l = insitu_locator_default();
  l.size = 3;
  EXPECT_EQ(insitu_mesh_locator(handle_, &l), INSITU_ERROR_ARGUMENT);
  insitu_locator_info i = insitu_locator_info_default();
  EXPECT_EQ(insitu_mesh_locator_info(handle_, &i), INSITU_ERROR_ORDER);
  EXPECT_EQ(insitu_mesh_locator_info(handle_, nullptr), INSITU_ERROR_ARGUMENT);
}

TEST_F(Locators, BackendsThatAreNotHereAreRefusedWithTheReason) {
  REQUIRE_OK(choose(INSITU_METHOD_SHARED_FACES, INSITU_BACKEND_CPU));
  const struct {
    insitu_method method;
    insitu_backend backend;
    std::string begins;
  } choices[] = {{INSITU_METHOD_BVH, INSITU_BACKEND_CUDA, "locator: backend cuda: "},
                 {INSITU_METHOD_USER_GEOMETRY, INSITU_BACKEND_OPTIX, "locator: backend optix: "}};
  int refused = 0;
  for (const auto& c : choices) {
    const insitu_status status = choose(c.method, c.backend);
    if (status == INSITU_OK) { // this machine has it
      REQUIRE_OK(choose(INSITU_METHOD_SHARED_FACES, INSITU_BACKEND_CPU));
      continue;
    }
    ++refused;
    EXPECT_EQ(status, INSITU_ERROR_UNSUPPORTED);
    const std::string text = message();
    ASSERT_EQ(text.substr(0, c.begins.size()), c.begins);
    // A build without it, no driver, no card, or one too old: each names what is missing.
    const std::string reason = text.substr(c.begins.size());
    EXPECT_TRUE(reason.find("CUDA") != std::string::npos ||
                reason.find("OptiX") != std::string::npos ||
                reason.find("libnvoptix") != std::string::npos)
        << text;
    // In a scene as well, with its line.
    insitu_session_options options = insitu_session_options_default();
    const std::string scene = c.backend == INSITU_BACKEND_CUDA
                                  ? "insitu: 1\nlocator: {method: bvh, backend: cuda}\n"
                                  : "insitu: 1\nlocator: {method: user_geometry, backend: optix}\n";
    options.scene_text = scene.c_str();
    insitu_session other = nullptr;
    EXPECT_EQ(insitu_session_open(&options, &other), INSITU_ERROR_UNSUPPORTED);
    EXPECT_EQ(message(), "scene:2: " + text);
  }
  // The choice before stands.
  REQUIRE_OK(insitu_mesh_commit(handle_, nullptr));
  EXPECT_EQ(info().method, INSITU_METHOD_SHARED_FACES);
  if (refused == 0)
    GTEST_SKIP() << "every backend can be used here";
}

TEST_F(Locators, DeviceMemoryNeedsADevice) {
  REQUIRE_OK(insitu_mesh_commit(handle_, nullptr));
  insitu_array points = insitu_array_of(points_.data(), INSITU_FLOAT64, 1, 3);
  insitu_locate_args args = insitu_locate_args_default();
  args.points = &points;
  args.memory = INSITU_DEVICE;
  EXPECT_EQ(insitu_mesh_locate(handle_, &args), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(message(), "points lie in host memory, the answers (memory) in the other; both in one "
                       "expected");
  points.memory = INSITU_DEVICE;
  EXPECT_EQ(insitu_mesh_locate(handle_, &args), INSITU_ERROR_UNSUPPORTED);
  args.memory = insitu_memory(7);
  EXPECT_EQ(insitu_mesh_locate(handle_, &args), INSITU_ERROR_ARGUMENT);
}

TEST_F(Locators, AdvancingNeedsADevice) {
  insitu_advance_args args = insitu_advance_args_default();
  args.velocity = "f";
  EXPECT_EQ(insitu_mesh_advance(handle_, &args), INSITU_ERROR_ORDER);
  REQUIRE_OK(insitu_mesh_commit(handle_, nullptr));
  EXPECT_EQ(insitu_mesh_advance(handle_, &args), INSITU_ERROR_UNSUPPORTED);
  EXPECT_EQ(insitu_mesh_advance(handle_, nullptr), INSITU_ERROR_ARGUMENT);
  args.size = 1;
  EXPECT_EQ(insitu_mesh_advance(handle_, &args), INSITU_ERROR_ARGUMENT);
}

TEST_F(Locators, OfAScene) {
  // A ray method without a backend falls back to Embree, and says so, where OptiX cannot be used.
  open("insitu: 1\nlocator: {method: shared_faces}\n");
  REQUIRE_OK(insitu_session_execute(session_, 0, 0.0));
  const insitu_locator_info first = info();
  EXPECT_EQ(first.method, INSITU_METHOD_SHARED_FACES);
  if (first.backend == INSITU_BACKEND_CPU) {
    EXPECT_NE(log_.find("no OptiX ("), std::string::npos) << log_;
  }
  // The caller's choice goes first; null gives it back.
  REQUIRE_OK(choose(INSITU_METHOD_BVH, INSITU_BACKEND_CPU));
  REQUIRE_OK(insitu_session_execute(session_, 1, 1.0));
  EXPECT_EQ(info().method, INSITU_METHOD_BVH);
  REQUIRE_OK(insitu_mesh_locator(handle_, nullptr));
  REQUIRE_OK(insitu_session_execute(session_, 2, 2.0));
  EXPECT_EQ(info().method, INSITU_METHOD_SHARED_FACES);

  // What cannot be had is an error when the session is opened, with the line.
  insitu_session_options options = insitu_session_options_default();
  options.scene_text = "insitu: 1\nlocator: {method: user_geometry, backend: cuda}\n";
  insitu_session other = nullptr;
  EXPECT_EQ(insitu_session_open(&options, &other), INSITU_ERROR_UNSUPPORTED);
  EXPECT_EQ(message(), "scene:2: locator: method user_geometry is not on backend cuda; cpu and "
                       "optix have it");
}
