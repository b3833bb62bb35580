/** @file session.h
 *  Sessions: opening, meshes by name, what a scene asks for each cycle. */
#ifndef INSITU_C_SESSION_H
#define INSITU_C_SESSION_H

#include "insitu/c/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum insitu_log_level INSITU_INT {
  INSITU_LOG_ERROR = 1,
  INSITU_LOG_WARNING = 2,
  INSITU_LOG_INFO = 3,
  INSITU_LOG_DEBUG = 4
} insitu_log_level;

/** Receives the library's messages, on the thread that called the library. Must not call back. */
typedef void (*insitu_log_function)(insitu_log_level level, const char* message, void* user);

/** The fortran_communicator of a session that is given none: a number that no MPI gives. 0 is one:
 *  Open MPI's MPI_COMM_WORLD. */
#define INSITU_NO_COMMUNICATOR (-1)

typedef struct insitu_session_options {
  size_t size;
  const char* scene;      /**< path of a scene file; null: none */
  const char* scene_text; /**< the scene itself, as text; at most one of both. With neither, the
                               default scene if default_scene is not 0, else nothing is executed */
  const char* output;     /**< output folder, overrides the scene's; null: the scene's */
  int32_t default_scene;  /**< 1: with no scene, draw the first scalar field every tenth cycle */
  int32_t threads;        /**< at most so many threads; 0: all that the process's affinity allows */
  int32_t strict;         /**< 1: refuse arrays that would have to be copied or converted */
  insitu_log_level log_level; /**< messages up to this level reach the log */
  insitu_log_function log;    /**< null: errors and warnings go to stderr */
  void* log_user;
  const void* communicator;     /**< address of an MPI_Comm; this version keeps it, does not use it,
                                     and logs what that means */
  int32_t fortran_communicator; /**< the same as a Fortran integer, if communicator is null;
                                     INSITU_NO_COMMUNICATOR: none */
  int32_t reserved;             /**< 0 */
} insitu_session_options;

static inline insitu_session_options insitu_session_options_default(void) {
  insitu_session_options o;
  o.size = sizeof o;
  o.scene = NULL;
  o.scene_text = NULL;
  o.output = NULL;
  o.default_scene = 0;
  o.threads = 0;
  o.strict = 0;
  o.log_level = INSITU_LOG_WARNING;
  o.log = NULL;
  o.log_user = NULL;
  o.communicator = NULL;
  o.fortran_communicator = INSITU_NO_COMMUNICATOR;
  o.reserved = 0;
  return o;
}

/** Opens a session. options may be null (the defaults). A bad scene is an error here, with file,
 *  line, key and the nearest valid key in the message; *session is then null. What is wrong is
 *  also logged, by the options' log or to stderr.
 *
 *  What a session writes is locked until it is closed, by folder and action: another session of
 *  this process or another one, such as a second rank in the same folder, gets INSITU_ERROR_FILE
 *  here, and the message names the file and who holds it. A run that was killed leaves locks that
 *  the next one on that host takes over. */
INSITU_API insitu_status insitu_session_open(const insitu_session_options* options,
                                             insitu_session* session);

/** Ends tracers, closes files, releases the session and its meshes, and sets *session to null.
 *  A null *session is fine. */
INSITU_API insitu_status insitu_session_close(insitu_session* session);

/** The mesh of that name, made empty on first use. */
INSITU_API insitu_status insitu_session_mesh(insitu_session session, const char* name,
                                             insitu_mesh* mesh);

/** Commits every mesh, then does what the scene asks for at this cycle: probes, tracers, frames.
 *  cycle: the solver's step number; time: its physical time (not decreasing while tracers live,
 *  and not increasing for those of `direction: backward`; particles wait where it does).
 *  An action that fails is logged and skipped; the others are done; the status is then
 *  INSITU_ERROR_ACTION and the message tells which. */
INSITU_API insitu_status insitu_session_execute(insitu_session session, int64_t cycle, double time);

/** Writes the state of the scene's tracers and attached probes after the last execute to a file,
 *  whole or not at all: particles, clocks of release, tracks, and what the next step needs of this
 *  one. To be called after insitu_session_execute() and before the arrays change. What tables hold
 *  back is written first. A scene can ask for it too: `checkpoint: {every: 100}`. */
INSITU_API insitu_status insitu_session_checkpoint(insitu_session session, const char* path);

/** Takes such a file up again, in a session with the same tracers, before its first execute: the
 *  solver goes on with the cycle after the checkpoint's, and the tracks go on to the bit as if
 * there had been no stop, in the same files, from which rows of later cycles are dropped. Meshes
 * may be registered before or after. A file that is damaged, foreign, or of another scene is
 *  INSITU_ERROR_FILE, and the session is as if it had not been asked for. */
INSITU_API insitu_status insitu_session_restart(insitu_session session, const char* path);

/** Commits every mesh, then tells what the scene needs of them, with bytes, and what it does
 *  without, and why: a line each. Nothing of it is done. *text stays valid until the session's next
 *  plan or its close; "" without a scene. */
INSITU_API insitu_status insitu_session_plan(insitu_session session, const char** text);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_SESSION_H */
