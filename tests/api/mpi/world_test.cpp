/// A World of MPI: mpiexec -n 1, 2, 3, 4, 8.
#include <dlfcn.h>
#include <sched.h>
#include <unistd.h>

#include "api/mpi/main.h"
#include "parallel/mpi/functions.h"
#include "parallel/mpi_world.h"
#include "unit/parallel/world_checks.h"

namespace insitu::test {
namespace {

std::shared_ptr<parallel::World> world_of(MPI_Comm communicator) {
  return parallel::make_mpi_world(&communicator, INSITU_NO_COMMUNICATOR, core::Log());
}

TEST(MpiWorld, KeepsItsPromises) {
  const auto world = world_of(MPI_COMM_WORLD);
  int size = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  EXPECT_EQ(world->size(), size);
  EXPECT_EQ(world->on_this_node(), size);
  check_all(*world);
}

TEST(MpiWorld, OfAFortranInteger) {
  const auto world = parallel::make_mpi_world(nullptr, MPI_Comm_c2f(MPI_COMM_WORLD), core::Log());
  check_reductions(*world);
}

/// Messages past what MPI's counts hold go in pieces: the limit is lowered.
TEST(MpiWorld, LongMessagesGoInPieces) {
  const auto world = world_of(MPI_COMM_WORLD);
  void* const library = dlopen("libinsitu-mpi.so." INSITU_TEST_VERSION, RTLD_NOW | RTLD_NOLOAD);
  ASSERT_NE(library, nullptr) << dlerror();
  const auto get =
      reinterpret_cast<const insitu_mpi_functions* (*)()>(dlsym(library, "insitu_mpi"));
  for (const std::size_t longest : {std::size_t(1000), std::size_t(4097)}) {
    const std::size_t before = get()->set_longest(longest);
    EXPECT_EQ(before, std::size_t(1) << 30);
    check_all(*world);
    get()->set_longest(before);
  }
}

/// Halves of the processes at the same time, and a World of each beside that of all.
TEST(MpiWorld, SubGroupsWorkByThemselves) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm half = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, rank % 2, -rank, &half);
  const auto all = world_of(MPI_COMM_WORLD), some = world_of(half);
  MPI_Comm_free(&half); // the World has its own
  check_all(*some);
  if (rank % 2)
    check_exchange(*some);
  check_all(*all);
}

/// Processes that are bound to cores of their own share all of these; those of a job that has a
/// part of the node share that part.
TEST(MpiWorld, CoresAreThoseThatAnyProcessOfTheNodeMayUse) {
  cpu_set_t before, all;
  ASSERT_EQ(sched_getaffinity(getpid(), sizeof before, &before), 0);
  MPI_Allreduce(&before, &all, sizeof all, MPI_BYTE, MPI_BOR, MPI_COMM_WORLD);
  std::vector<int> cores;
  for (int c = 0; c < CPU_SETSIZE; ++c)
    if (CPU_ISSET(c, &all))
      cores.push_back(c);
  EXPECT_EQ(world_of(MPI_COMM_WORLD)->cores_here(), int(cores.size()));
  const auto bind_to = [](int core) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    EXPECT_EQ(sched_setaffinity(getpid(), sizeof one, &one), 0);
  };
  bind_to(cores[std::size_t(rank()) % cores.size()]);
  EXPECT_EQ(world_of(MPI_COMM_WORLD)->cores_here(), std::min(size(), int(cores.size())));
  bind_to(cores[0]);
  EXPECT_EQ(world_of(MPI_COMM_WORLD)->cores_here(), 1);
  EXPECT_EQ(sched_setaffinity(getpid(), sizeof before, &before), 0);
}

TEST(MpiWorld, WhatIsNoCommunicatorToWorkOnIsRefused) {
  const MPI_Comm none = MPI_COMM_NULL;
  try {
    parallel::make_mpi_world(&none, INSITU_NO_COMMUNICATOR, core::Log());
    ADD_FAILURE();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_ARGUMENT);
    EXPECT_STREQ(e.what(), "communicator: MPI_COMM_NULL");
  }
  int rank = 0, size = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  if (size == 1)
    return;
  MPI_Comm side = MPI_COMM_NULL, between = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, rank == 0, rank, &side);
  MPI_Intercomm_create(side, 0, MPI_COMM_WORLD, rank == 0 ? 1 : 0, 3, &between);
  EXPECT_THROW(world_of(between), core::Error);
  MPI_Comm_free(&between);
  MPI_Comm_free(&side);
}

} // namespace
} // namespace insitu::test

int main(int argc, char** argv) {
  return run_on_all_processes(argc, argv);
}
