/// Two ranks with a session each, without a communicator, with one output folder and with two:
/// mpiexec -n 2.
#include <filesystem>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>

#include "fixtures/mpi.h"

namespace {

int rank() {
  int r = -1;
  EXPECT_EQ(sc_MPI_Comm_rank(sc_MPI_COMM_WORLD, &r), sc_MPI_SUCCESS);
  return r;
}
int sum_of(int mine) {
  int all = 0;
  EXPECT_EQ(sc_MPI_Allreduce(&mine, &all, 1, sc_MPI_INT, sc_MPI_SUM, sc_MPI_COMM_WORLD),
            sc_MPI_SUCCESS);
  return all;
}

struct Rank {
  std::unique_ptr<insitu::Session> session;
  std::string error;

  explicit Rank(const std::string& output) {
    insitu::Options o;
    o.scene_text = "insitu: 1\nprobes: [{name: gauges, points: [[0, 0, 0]], output: [csv, json]}]\n"
                   "frames: [{name: front, size: [16, 16], volume: {field: p}}]\n";
    o.output = output;
    o.log = [](insitu::LogLevel, const char*) {};
    try {
      session = std::make_unique<insitu::Session>(o);
    } catch (const insitu::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
      error = e.what();
    }
  }
};

TEST(Ranks, OfTwoInOneFolderOneIsRefused) {
  const std::string out = "ranks_out";
  if (rank() == 0)
    std::filesystem::remove_all(out);
  for (int round = 0; round < 10; ++round) {
    sum_of(0); // both start together
    const Rank mine(out);
    EXPECT_EQ(sum_of(mine.session != nullptr), 1);
    if (!mine.session) {
      EXPECT_NE(mine.error.find("ranks_out/"), std::string::npos) << mine.error;
      EXPECT_NE(mine.error.find("on this host"), std::string::npos) << mine.error;
      EXPECT_NE(mine.error.find("each rank, needs an output folder of its own"), std::string::npos)
          << mine.error;
    }
    sum_of(0);
  }
}

TEST(Ranks, WithFoldersOfTheirOwnBothWork) {
  const Rank mine("rank_" + std::to_string(rank()) + "_out");
  EXPECT_EQ(sum_of(mine.session != nullptr), 2);
}

} // namespace
