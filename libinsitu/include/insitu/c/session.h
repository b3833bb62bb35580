/** @file session.h
 *  Sessions: a solver opens one, names its meshes, and executes the scene each cycle. */
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

/** Receives the library's messages, on the thread that called the library. The function must not
 *  call the library. */
typedef void (*insitu_log_function)(insitu_log_level level, const char* message, void* user);

/** The fortran_communicator of a session that is given no communicator. No MPI has a communicator
 *  of this number, whereas 0 is Open MPI's MPI_COMM_WORLD. */
#define INSITU_NO_COMMUNICATOR (-1)

typedef struct insitu_session_options {
  size_t size;
  const char* scene;      /**< path of a scene file; null: no file */
  const char* scene_text; /**< the scene itself, as text; null: no text. A session takes one of
                               scene and scene_text at most. With neither it executes the default
                               scene if default_scene is not 0, else nothing */
  const char* output;     /**< output folder, which overrides the scene's; null: the scene's */
  int32_t default_scene;  /**< 1: a session without a scene draws the first scalar field every tenth
                               cycle */
  int32_t threads;        /**< the most threads that the session runs; 0: all that the process's
                               affinity allows, of several processes its share of the node's
                               cores; or INSITU_LACKS_MEMORY */
  int32_t strict;         /**< 1: commits refuse arrays that would have to be copied or converted */
  insitu_log_level log_level; /**< messages up to this level reach the log */
  insitu_log_function log;    /**< null: errors and warnings go to stderr */
  void* log_user;
  const void* communicator;     /**< address of an MPI_Comm, which is duplicated, or null. With it,
                                     opening, executing and closing the session are collective
                                     over its processes, and so are plans, checkpoints, restarts
                                     and summaries; the root, rank 0, reads and writes the files.
                                     A build without MPI logs that it does not use it */
  int32_t fortran_communicator; /**< the communicator as a Fortran integer, if communicator is null;
                                     INSITU_NO_COMMUNICATOR: no communicator */
  int32_t preview;              /**< 1: each execute draws every frame of the scene, whatever its
                                     trigger, at 160 x 120 pixels at most, into the folder `preview`
                                     of the output folder, and does nothing else of the scene */
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
  o.preview = 0;
  return o;
}

/** Opens a session. options null means the defaults. A bad scene is an error of this call, whose
 *  message gives file, line, key and the nearest valid key; *session is then null. The call also
 *  logs what is wrong, by the options' log or to stderr. With a communicator the call is
 *  collective: all processes return the same status, and a message that names the first one that
 *  failed, which the root's log alone tells. INSITU_ERROR_UNSUPPORTED: the program has another MPI
 *  than libinsitu-mpi, or that library is not found; INSITU_ERROR_ORDER: MPI is not initialised, or
 *  is finalised, or another thread calls.
 *
 *  A session locks what it writes, by folder and action, until it is closed: another session of
 *  this process or of another one, such as a second rank in the same folder, gets INSITU_ERROR_FILE
 *  here, and the message names the file and who holds it. A run that was killed leaves locks that
 *  the next run on that host takes over. */
INSITU_API insitu_status insitu_session_open(const insitu_session_options* options,
                                             insitu_session* session);

/** Ends tracers, closes files, releases the session and its meshes, and sets *session to null. The
 *  call succeeds where *session is null already. */
INSITU_API insitu_status insitu_session_close(insitu_session* session);

/** Writes the handle of the mesh of that name, which the first call makes, empty. The session owns
 *  the mesh. */
INSITU_API insitu_status insitu_session_mesh(insitu_session session, const char* name,
                                             insitu_mesh* mesh);

/** Commits every mesh, then runs the probes, tracers and frames that the scene asks for at this
 *  cycle. cycle: the solver's step number. time: the solver's physical time. While tracers live it
 *  must not decrease, nor increase for tracers of `direction: backward`; at a cycle where it does,
 *  the tracer fails and its particles wait where they are. The library logs an action that fails,
 *  skips it and runs all other actions; the status is then INSITU_ERROR_ACTION, and the message
 *  names the action; a call with the same cycle and time after that does what failed alone.
 *  INSITU_ERROR_MESH, INSITU_ERROR_FIELD: a mesh was refused, and nothing is executed. */
INSITU_API insitu_status insitu_session_execute(insitu_session session, int64_t cycle, double time);

/** Writes the state of the scene's tracers and attached probes after the last execute to a file,
 *  whole or not at all: particles, clocks of release, tracks, and what the next step needs of this
 *  one. The caller calls it after insitu_session_execute() and before the arrays change. The
 *  library first writes the rows that tables hold back. A scene can ask for checkpoints too:
 *  `checkpoint: {every: 100}`. INSITU_ERROR_ORDER: nothing was executed yet, or a mesh was changed
 *  since. Collective: all processes give the same path, and the root writes the one file. */
INSITU_API insitu_status insitu_session_checkpoint(insitu_session session, const char* path);

/** Takes up a checkpoint's file, in a session with the same tracers, before the session's first
 *  execute. The solver goes on with the cycle after the checkpoint's. The tracks go on as if there
 *  had been no stop, equal to the bit, in the same files, from which the library drops rows of
 *  later cycles. The caller may register meshes before or after. INSITU_ERROR_ORDER: the session
 *  has no scene, or has executed already. INSITU_ERROR_FILE: the file is damaged, foreign, or of
 *  another scene; the session is then as if the call had not been made. Collective; as many
 *  processes as wrote the file, more or fewer may take it up (doc/guide/restart.md). */
INSITU_API insitu_status insitu_session_restart(insitu_session session, const char* path);

/** Writes what the last execute committed to one VTKHDF file (`.hdf`), whole or not at all: all
 *  meshes with their pieces, fields, ghosts and frames, the cycle, the time and the scene, in the
 *  precision of the caller's arrays. The caller calls it after insitu_session_execute() and before
 *  the arrays change. A scene can ask for records too: `record: {every: 10}`. `insitu-replay` gives
 *  the same tables, tracks and frames from the records of all cycles as the run did, and readers of
 *  VTKHDF show unstructured and uniform meshes. INSITU_ERROR_ORDER: nothing was executed yet, or a
 *  mesh was changed since. INSITU_ERROR_UNSUPPORTED: this build has no HDF5, or a mesh lies on a
 *  device. Collective: all processes give the same path, and the root writes the one file. */
INSITU_API insitu_status insitu_session_record(insitu_session session, const char* path);

/** The cycle that insitu_session_show() takes for the live step, and no execute's cycle. */
#define INSITU_LIVE INT64_MIN

/** Holds steps beside the live one: from now on each execute of the live step, once it is done,
 *  leaves a copy of what the solver gave, with the trees that stand, and of these the last `steps`
 *  stay. The oldest goes first; a step replaces the one of its cycle, if that is held. Of meshes
 *  that stood still between two steps only the fields are copied. 0: releases all; that is how a
 *  session begins, unless its scene says `hold: {steps: 3}`. Copies are INSITU_MEMORY_HELD. A step
 *  that cannot be held, for want of memory or since a mesh lies on a device, is a failure of that
 *  execute (INSITU_ERROR_ACTION); those before stay, but for the one whose place it was to take.
 *  INSITU_ERROR_ARGUMENT: steps is negative. INSITU_ERROR_ORDER: a held step is shown. Collective
 *  (doc/guide/held-steps.md). */
INSITU_API insitu_status insitu_session_hold(insitu_session session, int32_t steps);

/** Writes the cycles that are held, the oldest first, at most *count of them, and their number to
 *  *count; cycles null: the number alone. */
INSITU_API insitu_status insitu_session_held(insitu_session session, int64_t* cycles,
                                             int32_t* count);

/** Shows a held step; no tree is built. Until the next call queries of the session's meshes are
 *  answered from it, to the bit as when it was live; insitu_session_record() writes it, and
 *  insitu_session_execute() runs the scene's probes, streamlines and frames on it, by whatever
 *  cycle and time it is given, and neither commits nor holds anything. Tracers of particles,
 *  attached probes, registrations, commits, plans and checkpoints go on with live steps alone.
 *  INSITU_LIVE shows the live step again. INSITU_ERROR_ARGUMENT: the cycle is not held; the message
 *  names those that are, and the session shows what it showed. INSITU_ERROR_ORDER, of a query: the
 *  mesh was not there in that step. Collective. */
INSITU_API insitu_status insitu_session_show(insitu_session session, int64_t cycle);

/** Commits every mesh, then writes a text that tells, a line each, what the scene needs of the
 *  meshes, with bytes, and what it does without, and why. Nothing of the plan is carried out. *text
 *  is the library's and stays valid until the session's next plan or its close; it is "" without a
 *  scene. Collective; each process's text is of its own pieces. */
INSITU_API insitu_status insitu_session_plan(insitu_session session, const char** text);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_SESSION_H */
