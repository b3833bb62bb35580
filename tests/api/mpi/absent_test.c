/* A process that does not come is named, and nobody hangs: mpiexec -n 3, INSITU_CHECKED=1, a short
 * INSITU_WAIT. Once the last process does not call, once the root; at last one does
 * not open. */
#include <insitu/insitu.h>
#include <mpi.h>
#include <stdio.h>
#include <string.h>

static void quiet(insitu_log_level level, const char* message, void* user) {
  (void)level, (void)message, (void)user;
}

static int wrong(int rank, const char* what, insitu_status got, insitu_status expected,
                 const char* says) {
  if (got == expected && strstr(insitu_last_message(), says))
    return 0;
  fprintf(stderr, "process %d, %s: %s with '%s' expected, %s: %s\n", rank, what,
          insitu_status_name(expected), says, insitu_status_name(got), insitu_last_message());
  return 1;
}

/* Two cycles together; the absent process leaves out the third, which it calls late. */
static int run(int rank, int absent, const char* name) {
  int failed = 0;
  insitu_session session = NULL;
  insitu_session_options options = insitu_session_options_default();
  const MPI_Comm world = MPI_COMM_WORLD;
  options.communicator = &world;
  options.log = quiet;
  failed += wrong(rank, "open", insitu_session_open(&options, &session), INSITU_OK, "");
  for (int cycle = 0; cycle < 2; ++cycle)
    failed += wrong(rank, "execute", insitu_session_execute(session, cycle, cycle), INSITU_OK, "");
  if (rank == absent)
    MPI_Barrier(MPI_COMM_WORLD);
  const double begin = MPI_Wtime();
  const insitu_status status = insitu_session_execute(session, 2, 2);
  const double waited = MPI_Wtime() - begin;
  /* One that is late hears of itself, unless the root, for which it waits, is gone. */
  failed += wrong(rank, "the third execute", status, INSITU_ERROR_ORDER,
                  rank == absent ? "did not call it within" : name);
  if (waited > 20) {
    fprintf(stderr, "process %d waited for %g s\n", rank, waited);
    ++failed;
  }
  failed += wrong(rank, "a further execute", insitu_session_execute(session, 3, 3),
                  INSITU_ERROR_ORDER, "can only be closed");
  failed += wrong(rank, "close", insitu_session_close(&session), INSITU_ERROR_ORDER,
                  "can only be closed");
  if (rank != absent)
    MPI_Barrier(MPI_COMM_WORLD);
  return failed;
}

/* The last process opens no session until the others have given up, in a communicator of their own,
 * which is of no use afterwards. */
static int open_without_one(int rank) {
  int failed = 0;
  insitu_session session = NULL;
  insitu_session_options options = insitu_session_options_default();
  MPI_Comm own = MPI_COMM_NULL;
  MPI_Comm_dup(MPI_COMM_WORLD, &own);
  options.communicator = &own;
  options.log = quiet;
  if (rank == 2)
    MPI_Barrier(MPI_COMM_WORLD);
  const double begin = MPI_Wtime();
  failed +=
      wrong(rank, "open", insitu_session_open(&options, &session), INSITU_ERROR_ORDER,
            rank == 2 ? "communicator: "
                      : "communicator: not all of its 3 processes opened a session within 4 s");
  if (session || MPI_Wtime() - begin > 20) {
    fprintf(stderr, "process %d waited for %g s, or has a session\n", rank, MPI_Wtime() - begin);
    ++failed;
  }
  if (rank != 2)
    MPI_Barrier(MPI_COMM_WORLD);
  return failed;
}

int main(int argc, char** argv) {
  int failed = 0, any = 0, rank = 0;
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  failed += run(rank, 2, "execute: process 2 of 3 did not call it within 4 s");
  failed += run(rank, 0, "execute: process 0 of 3 did not call it within 4 s");
  failed += open_without_one(rank); /* last: no session can be opened any more */
  MPI_Allreduce(&failed, &any, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  MPI_Finalize();
  return any != 0;
}
