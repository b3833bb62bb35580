/* One process does not find libinsitu-mpi: mpiexec -n 3 no_library.sh, INSITU_CHECKED=1, a short
 * INSITU_WAIT. It says so at once and by name; the others do not wait for it without end. */
#include <insitu/insitu.h>
#include <mpi.h>
#include <stdio.h>
#include <string.h>

static void quiet(insitu_log_level level, const char* message, void* user) {
  (void)level, (void)message, (void)user;
}

static int lacks(const char* said, const char* text) {
  if (!strstr(said, text))
    fprintf(stderr, "'%s' is not in: %s\n", text, said);
  return !strstr(said, text);
}

int main(int argc, char** argv) {
  int failed = 0, rank = 0;
  insitu_session session = NULL;
  insitu_session_options options = insitu_session_options_default();
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm own = MPI_COMM_NULL; /* of no use afterwards */
  MPI_Comm_dup(MPI_COMM_WORLD, &own);
  options.communicator = &own;
  options.log = quiet;
  const double begin = MPI_Wtime();
  const insitu_status status = insitu_session_open(&options, &session);
  const double waited = MPI_Wtime() - begin;
  const char* said = insitu_last_message();
  if (rank == 1) {
    failed += status != INSITU_ERROR_UNSUPPORTED || waited > 1;
    failed += lacks(said, "communicator: libinsitu-mpi.so.");
    failed += lacks(said, " cannot be used by this process, on host '");
    failed += lacks(said, "cannot open shared object file");
    failed += lacks(said, "wait for this one");
  } else {
    failed += status != INSITU_ERROR_ORDER || waited > 20;
    failed += lacks(said, "communicator: not all of its 3 processes opened a session within 2 s");
  }
  if (failed)
    fprintf(stderr, "process %d, after %g s: %s: %s\n", rank, waited, insitu_status_name(status),
            said);
  int any = 0;
  MPI_Allreduce(&failed, &any, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  if (rank == 1 && !any) { /* what the others have begun is ended, so that MPI can be */
    MPI_Comm late = MPI_COMM_NULL;
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Comm_idup(own, &late, &request);
    MPI_Wait(&request, MPI_STATUS_IGNORE);
  }
  MPI_Finalize();
  return any != 0;
}
