// A build without libinsitu-mpi: parallel/mpi_world.cpp is compiled once more for this program,
// without the name of that library.
#include <gtest/gtest.h>
#include <insitu/insitu.h>
#include <string>
#include <vector>

#include "parallel/mpi_world.h"
#include "unit/parallel/threaded_world.h"

namespace insitu::test {
namespace {

/// The session says that it does not use the communicator, and works on the process's own pieces.
TEST(WithoutMpi, ACommunicatorIsNotUsed) {
  ASSERT_FALSE(parallel::has_mpi());
  const auto expect_told = [](const void* communicator, std::int32_t fortran_communicator) {
    std::vector<std::string> messages;
    insitu_session_options o = insitu_session_options_default();
    o.communicator = communicator;
    o.fortran_communicator = fortran_communicator;
    o.log = [](insitu_log_level level, const char* message, void* user) {
      EXPECT_EQ(level, INSITU_LOG_WARNING);
      static_cast<std::vector<std::string>*>(user)->push_back(message);
    };
    o.log_user = &messages;
    insitu_session session = nullptr;
    ASSERT_EQ(insitu_session_open(&o, &session), INSITU_OK) << insitu_last_message();
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_EQ(messages[0].find("communicator: this build has no MPI and does not use it. Each "
                               "process works on its own pieces alone; "),
              0u)
        << messages[0];
    EXPECT_EQ(insitu_session_execute(session, 0, 0.0), INSITU_OK) << insitu_last_message();
    EXPECT_EQ(insitu_session_close(&session), INSITU_OK);
  };
  const int something = 0;
  expect_told(&something, INSITU_NO_COMMUNICATOR);
  expect_told(nullptr, 0); // Open MPI's MPI_COMM_WORLD in Fortran
}

TEST(WithoutMpi, AWorldOfProcessesIsRefused) {
  try {
    parallel::make_mpi_world(nullptr, 0, core::Log());
    FAIL();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_UNSUPPORTED);
    EXPECT_STREQ(e.what(), "communicator: this build has no MPI");
  }
}

} // namespace
} // namespace insitu::test
