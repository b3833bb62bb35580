/* MPI not initialised yet, and finalised too early: errors, and no crash. */
#include <insitu/insitu.h>
#include <mpi.h>
#include <stdio.h>
#include <string.h>

static int wrong(const char* what, insitu_status got, insitu_status expected, const char* says) {
  const char* said = insitu_last_message();
  if (got == expected && strstr(said, says))
    return 0;
  fprintf(stderr, "%s: %s expected, %s: %s\n", what, insitu_status_name(expected),
          insitu_status_name(got), said);
  return 1;
}

static void quiet(insitu_log_level level, const char* message, void* user) {
  (void)level, (void)message, (void)user;
}

int main(int argc, char** argv) {
  int failed = 0;
  insitu_session session = NULL;
  insitu_session_options options = insitu_session_options_default();
  const MPI_Comm world = MPI_COMM_WORLD;
  options.communicator = &world;
  options.log = quiet;
  failed += wrong("before MPI_Init", insitu_session_open(&options, &session), INSITU_ERROR_ORDER,
                  "is not initialised");
  MPI_Init(&argc, &argv);
  failed += wrong("open", insitu_session_open(&options, &session), INSITU_OK, "");
  failed += wrong("execute", insitu_session_execute(session, 0, 0.0), INSITU_OK, "");
  MPI_Finalize();
  failed += wrong("execute after MPI_Finalize", insitu_session_execute(session, 1, 0.1),
                  INSITU_ERROR_ORDER, "MPI is finalised");
  failed += wrong("close after MPI_Finalize", insitu_session_close(&session), INSITU_ERROR_ORDER,
                  "MPI is finalised");
  return failed;
}
