#include "parallel/mpi_world.h"
#include "unit/parallel/threaded_world.h"
#include "unit/parallel/world_checks.h"

namespace insitu::test {
namespace {

TEST(World, KeepsItsPromisesAlone) {
  parallel::SerialWorld world;
  check_all(world);
}

TEST(World, KeepsItsPromisesOnAnyNumberOfProcesses) {
  for (const int size : {1, 2, 3, 4, 8}) {
    SCOPED_TRACE(size);
    run_processes(size, [](parallel::World& world) { check_all(world); });
  }
}

/// Of one process nothing is sent, so nothing is cut.
TEST(World, AMessageOfOneProcessIsWhole) {
  const std::string what(9000, 'x');
  parallel::SerialWorld world;
  try {
    world.agree_after([&] { throw core::Error(INSITU_ERROR_SCENE, what); });
    ADD_FAILURE();
  } catch (const parallel::AgreedError& e) {
    EXPECT_EQ(e.what(), what);
    EXPECT_EQ(e.status(), INSITU_ERROR_SCENE);
  }
}

/// One that cannot send its parcels makes nobody wait for them.
TEST(World, AFailureWithinAnExchangeIsAgreedOn) {
  run_processes(3, [](parallel::World& world) {
    std::vector<parallel::Parcel> parcels{{0, {std::byte(1)}}};
    if (world.rank() == 1)
      parcels.push_back({7, {}}); // there is no such process
    try {
      world.exchange(parcels);
      ADD_FAILURE();
    } catch (const parallel::AgreedError& e) {
      EXPECT_EQ(message_of(e).find("process 1 of 3: "), 0u) << e.what();
    }
    check_exchange(world); // and all go on together
  });
}

TEST(World, SumsOfDoublesAreRefused) {
  parallel::SerialWorld world;
  double one[] = {1};
  EXPECT_THROW(world.reduce(std::span(one), parallel::Reduction::sum), core::Error);
}

TEST(World, KnowsOtherMpisByTheirFiles) {
  EXPECT_STREQ(parallel::mpi_of("libmpi.so.40"), "Open MPI");
  EXPECT_STREQ(parallel::mpi_of("libmpi.so.40.30.4"), "Open MPI");
  EXPECT_STREQ(parallel::mpi_of("libmpich.so.12"), "MPICH");
  EXPECT_EQ(parallel::mpi_of("libmpi_cxx.so.40"), nullptr);
  EXPECT_EQ(parallel::mpi_of("libc.so.6"), nullptr);
}

} // namespace
} // namespace insitu::test
