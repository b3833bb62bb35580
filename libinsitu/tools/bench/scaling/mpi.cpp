#include <cstdio>
#include <exception>
#include <mpi.h>

#include "core/log.h"
#include "parallel/mpi_world.h"
#include "scaling/cases.h"

namespace insitu::bench::scaling {

std::string launcher() {
  return INSITU_BENCH_MPIEXEC;
}

int run_on_mpi(const Options& options, const std::function<void(const std::vector<Row>&)>& take) {
  int level = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);
  try {
    const MPI_Comm all = MPI_COMM_WORLD;
    const auto world = parallel::make_mpi_world(&all, INSITU_NO_COMMUNICATOR, core::Log());
    const std::vector<Row> rows = measure(*world, options);
    if (world->is_root())
      take(rows);
  } catch (const std::exception& e) { // the other processes may wait
    std::fprintf(stderr, "insitu-bench scaling: %s\n", e.what());
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Finalize();
  return 0;
}

} // namespace insitu::bench::scaling
