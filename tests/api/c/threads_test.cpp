#include <atomic>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

#include "insitu/insitu.h"

// One thread is held inside a session by the log callback while another one calls: it is told so.
namespace {

struct Held {
  std::atomic<bool> inside{false}, release{false};
};

void hold(insitu_log_level, const char*, void* user) {
  auto* held = static_cast<Held*>(user);
  held->inside = true;
  while (!held->release)
    std::this_thread::yield();
}

} // namespace

TEST(Threads, ASecondThreadInOneSessionIsToldSo) {
  Held held;
  insitu_session_options options = insitu_session_options_default();
  options.log = hold;
  options.log_user = &held;
  insitu_session session = nullptr;
  ASSERT_EQ(insitu_session_open(&options, &session), INSITU_OK);
  insitu_mesh mesh = nullptr;
  ASSERT_EQ(insitu_session_mesh(session, "flat", &mesh), INSITU_OK);
  // A cell without volume makes the commit log a warning.
  const double points[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  const std::int32_t ids[4] = {0, 1, 2, 3};
  insitu_array a = insitu_array_of(points, INSITU_FLOAT64, 4, 3);
  insitu_cells cells = insitu_cells_default();
  cells.shape = INSITU_TETRAHEDRON;
  cells.count = 1;
  cells.connectivity = insitu_array_of(ids, INSITU_INT32, 1, 4);
  ASSERT_EQ(insitu_mesh_points(mesh, 0, &a, 1), INSITU_OK);
  ASSERT_EQ(insitu_mesh_cells(mesh, 0, &cells), INSITU_OK);

  std::thread first([&] { EXPECT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK); });
  while (!held.inside)
    std::this_thread::yield();
  EXPECT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_ERROR_BUSY);
  EXPECT_EQ(insitu_session_close(&session), INSITU_ERROR_BUSY);
  EXPECT_NE(session, nullptr);
  EXPECT_NE(std::string(insitu_last_message()).find("another thread"), std::string::npos);
  held.release = true;
  first.join();
  EXPECT_EQ(insitu_session_close(&session), INSITU_OK);
}

TEST(Threads, SessionsOfTheirOwnRunSideBySide) {
  std::vector<std::thread> threads;
  std::atomic<int> failed{0};
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) {
        insitu_session session = nullptr;
        insitu_mesh mesh = nullptr;
        insitu_block block = insitu_block_default();
        block.kind = INSITU_BLOCK_UNIFORM;
        for (std::int64_t& n : block.vertices)
          n = 9;
        failed += insitu_session_open(nullptr, &session) != INSITU_OK;
        failed += insitu_session_mesh(session, "grid", &mesh) != INSITU_OK;
        failed += insitu_mesh_block(mesh, 0, &block) != INSITU_OK;
        failed += insitu_mesh_commit(mesh, nullptr) != INSITU_OK;
        const double point[3] = {3.5, 0.5, 0.5};
        insitu_array where = insitu_array_of(point, INSITU_FLOAT64, 1, 3);
        std::int64_t cell = -1;
        insitu_locate_args args = insitu_locate_args_default();
        args.points = &where;
        args.cells = &cell;
        failed += insitu_mesh_locate(mesh, &args) != INSITU_OK || cell != 3;
        failed += insitu_session_close(&session) != INSITU_OK;
      }
    });
  for (std::thread& t : threads)
    t.join();
  EXPECT_EQ(failed, 0);
}
