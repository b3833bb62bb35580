#define _GNU_SOURCE /* nanosleep, sched_getaffinity */

#include "parallel/mpi/functions.h"

#include <mpi.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

struct insitu_mpi_world {
  MPI_Comm communicator; /* the session's own */
  int rank, size;
  int missing; /* a process that did not come, after which nothing is sent any more; or -1 */
  int told;    /* what the root says of that; here, as a message may come late */
  MPI_Request* requests; /* room for those of a call */
  size_t room;
};

static size_t longest = (size_t)1 << 30;

static int fail(int status, char* message, const char* text) {
  snprintf(message, INSITU_MPI_MESSAGE, "%s", text);
  return status;
}

static int failed(const char* function, int error, char* message) {
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(error, text, &length);
  snprintf(message, INSITU_MPI_MESSAGE, "%s: %.900s", function, text);
  return INSITU_MPI_FAILED;
}

/* Whether MPI may be called now, and here. */
static int check(char* message) {
  int yes = 0;
  if (MPI_Initialized(&yes) != MPI_SUCCESS || !yes) {
    char text[MPI_MAX_LIBRARY_VERSION_STRING] = "";
    int length = 0;
    MPI_Get_library_version(text, &length);
    for (int i = 0; i < length; ++i) /* what follows the name and the version is long */
      if (text[i] == ',' || text[i] == '\n')
        text[i] = '\0';
    snprintf(message, INSITU_MPI_MESSAGE,
             "the MPI that libinsitu-mpi is built with (%.200s) is not initialised: initialise MPI "
             "before the session is opened, or build libinsitu with the program's MPI",
             text);
    return INSITU_MPI_ORDER;
  }
  if (MPI_Finalized(&yes) != MPI_SUCCESS || yes)
    return fail(INSITU_MPI_ORDER, message, "MPI is finalised already; close sessions before");
  if (MPI_Is_thread_main(&yes) != MPI_SUCCESS || !yes) {
    int level = MPI_THREAD_SINGLE;
    MPI_Query_thread(&level);
    if (level < MPI_THREAD_SERIALIZED)
      return fail(INSITU_MPI_THREAD, message,
                  "called by another thread than the one that initialised MPI, which MPI was not "
                  "initialised for (MPI_THREAD_SERIALIZED)");
  }
  return INSITU_MPI_OK;
}

static int close_world(insitu_mpi_world* world, char* message) {
  const int status = check(message);
  if (status == INSITU_MPI_OK && world->missing < 0)
    MPI_Comm_free(&world->communicator);
  if (world->missing < 0) {
    free(world->requests);
    free(world);
  }
  return status;
}

static int make_room(insitu_mpi_world* world, size_t requests, char* message) {
  if (requests <= world->room)
    return INSITU_MPI_OK;
  MPI_Request* const more = malloc(requests * sizeof *more);
  if (!more)
    return fail(INSITU_MPI_MEMORY, message, "out of memory for MPI's requests");
  free(world->requests);
  world->requests = more;
  world->room = requests;
  return INSITU_MPI_OK;
}

/* The lowest rank of those that have no memory for their part of a world; their number if all have
 * it. */
static int find_lacking(MPI_Comm communicator, int lacks, int rank, int size) {
  int first = lacks ? rank : size;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, communicator);
  return first;
}

/* Whether messages may be sent in this world. */
static int check_world(const insitu_mpi_world* world, char* message) {
  const int status = check(message);
  if (status != INSITU_MPI_OK || world->missing < 0)
    return status;
  snprintf(message, INSITU_MPI_MESSAGE,
           "process %d of %d did not come in time before; the session can only be closed",
           world->missing, world->size);
  return INSITU_MPI_ORDER;
}

/* Tests the request until the time comes; returns whether it is done. A sleep leaves the core to
 * processes that share it. */
static int is_done_by(MPI_Request* request, double deadline) {
  const struct timespec pause = {0, 50000};
  for (int polls = 0;; ++polls) {
    int done = 0;
    if (MPI_Test(request, &done, MPI_STATUS_IGNORE) != MPI_SUCCESS || done)
      return done;
    if (MPI_Wtime() > deadline)
      return 0;
    if (polls > 1000)
      nanosleep(&pause, NULL);
  }
}

/* The same of a message, which is given up then. */
static int await(MPI_Request* request, double deadline) {
  const int done = is_done_by(request, deadline);
  if (!done && *request != MPI_REQUEST_NULL) {
    MPI_Cancel(request);
    MPI_Request_free(request);
  }
  return done;
}

enum { tag_here = 2, tag_verdict = 3, tag_gone = 4 };

/* The root: who does not come until the deadline; itself, if others have waited for it in vain. */
static int find_missing(const insitu_mpi_world* world, double deadline) {
  int missing = -1, gone = 0;
  for (int r = world->size - 1; r > 0; --r) { /* the lowest is left */
    MPI_Request coming = MPI_REQUEST_NULL;
    MPI_Irecv(NULL, 0, MPI_BYTE, r, tag_here, world->communicator, &coming);
    if (!await(&coming, deadline))
      missing = r;
  }
  MPI_Iprobe(MPI_ANY_SOURCE, tag_gone, world->communicator, &gone, MPI_STATUS_IGNORE);
  return gone ? 0 : missing;
}

/* All tell the root that they are here, and the root tells them who is not. */
static int wait_for_all(insitu_mpi_world* world, double seconds, int* missing, char* message) {
  const int status = check_world(world, message);
  if (status != INSITU_MPI_OK)
    return status;
  const double begin = MPI_Wtime();
  MPI_Request request = MPI_REQUEST_NULL;
  if (world->rank == 0) {
    world->told = find_missing(world, begin + seconds);
    for (int r = 1; r < world->size; ++r) { /* those that are not here may come yet */
      MPI_Isend(&world->told, 1, MPI_INT, r, tag_verdict, world->communicator, &request);
      await(&request, MPI_Wtime() + 1);
    }
  } else {
    MPI_Isend(NULL, 0, MPI_BYTE, 0, tag_here, world->communicator, &request);
    int heard = await(&request, begin + 2 * seconds);
    if (heard) {
      MPI_Irecv(&world->told, 1, MPI_INT, 0, tag_verdict, world->communicator, &request);
      heard = await(&request, begin + 2 * seconds);
    }
    if (!heard) {
      world->told = 0;
      MPI_Isend(NULL, 0, MPI_BYTE, 0, tag_gone, world->communicator, &request);
      await(&request, MPI_Wtime() + 1);
    }
  }
  *missing = world->missing = world->told;
  return INSITU_MPI_OK;
}

/* The caller's communicator once more, on all processes. seconds: how long those that came wait for
 * the others, or 0: without end. What is under way then cannot be taken back. */
static int duplicate(MPI_Comm given, double seconds, MPI_Comm* own, char* message) {
  static MPI_Comm made; /* as MPI may write to it after that time */
  static int is_given_up = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  if (is_given_up)
    return fail(INSITU_MPI_ORDER, message,
                "an opening before waited for a process in vain; the program is to end");
  int error = MPI_Comm_idup(given, &made, &request);
  if (error == MPI_SUCCESS && seconds > 0 && !is_done_by(&request, MPI_Wtime() + seconds)) {
    int size = 0;
    MPI_Comm_size(given, &size);
    is_given_up = 1;
    snprintf(message, INSITU_MPI_MESSAGE,
             "communicator: not all of its %d processes opened a session within %g s (INSITU_WAIT)",
             size, seconds);
    return INSITU_MPI_ORDER;
  }
  if (error == MPI_SUCCESS)
    error = MPI_Wait(&request, MPI_STATUS_IGNORE);
  if (error != MPI_SUCCESS)
    return failed("MPI_Comm_idup", error, message);
  *own = made;
  return INSITU_MPI_OK;
}

/* How many cores any of the node's processes may use. A launcher binds each to its own; a job's
 * part of a node binds all of them to the same. */
static int count_cores(MPI_Comm node) {
  enum { words = 128 }; /* 8192 cores */
  uint64_t cores[words] = {0};
  int count = 0;
  if (sched_getaffinity(getpid(), sizeof cores, (cpu_set_t*)cores) != 0)
    for (long c = 0; c < sysconf(_SC_NPROCESSORS_ONLN) && c < 64 * words; ++c)
      cores[c / 64] |= (uint64_t)1 << c % 64;
  MPI_Allreduce(MPI_IN_PLACE, cores, words, MPI_UINT64_T, MPI_BOR, node);
  for (int w = 0; w < words; ++w)
    for (; cores[w]; cores[w] &= cores[w] - 1)
      ++count;
  return count;
}

static int open_world(const void* given, int fortran, int lacks, double seconds,
                      insitu_mpi_world** made, int* rank, int* size, int* on_this_node,
                      int* cores_here, int* single_threaded, char* message) {
  int status = check(message), inter = 0, missing = -1, level = MPI_THREAD_SINGLE;
  MPI_Comm own = MPI_COMM_NULL, node = MPI_COMM_NULL;
  *rank = -1;
  if (status != INSITU_MPI_OK)
    return status;
  const MPI_Comm communicator = given ? *(const MPI_Comm*)given : MPI_Comm_f2c((MPI_Fint)fortran);
  if (communicator == MPI_COMM_NULL)
    return fail(INSITU_MPI_ARGUMENT, message, "communicator: MPI_COMM_NULL");
  MPI_Comm_test_inter(communicator, &inter);
  if (inter)
    return fail(INSITU_MPI_ARGUMENT, message,
                "communicator: an intercommunicator, an intracommunicator expected");
  status = duplicate(communicator, seconds, &own, message);
  if (status != INSITU_MPI_OK)
    return status;
  MPI_Comm_set_errhandler(own, MPI_ERRORS_RETURN);
  MPI_Comm_rank(own, rank);
  MPI_Comm_size(own, size);
  insitu_mpi_world here = {.communicator = own, .rank = *rank, .size = *size, .missing = -1};
  if (seconds > 0) /* one that is late finds the others gone */
    status = wait_for_all(&here, seconds, &missing, message);
  if (status == INSITU_MPI_OK && missing >= 0) {
    snprintf(message, INSITU_MPI_MESSAGE,
             "communicator: process %d of %d did not open a session within %g s (INSITU_WAIT)",
             missing, *size, seconds);
    return INSITU_MPI_ORDER;
  }
  if (status != INSITU_MPI_OK)
    return status;
  insitu_mpi_world* world = lacks ? NULL : malloc(sizeof *world);
  MPI_Request* requests = world ? malloc((size_t)*size * sizeof *requests) : NULL;
  const int lacking = find_lacking(own, !requests, *rank, *size);
  if (lacking < *size) {
    free(world);
    free(requests);
    MPI_Comm_free(&own);
    snprintf(message, INSITU_MPI_MESSAGE, "process %d of %d: out of memory", lacking, *size);
    return INSITU_MPI_MEMORY;
  }
  *world = here;
  world->requests = requests;
  world->room = (size_t)*size;
  *on_this_node = 1;
  *cores_here = (int)sysconf(_SC_NPROCESSORS_ONLN);
  const int error = MPI_Comm_split_type(own, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  if (error == MPI_SUCCESS && node != MPI_COMM_NULL) {
    MPI_Comm_size(node, on_this_node);
    *cores_here = count_cores(node);
    MPI_Comm_free(&node);
  }
  MPI_Query_thread(&level);
  *single_threaded = level == MPI_THREAD_SINGLE;
  *made = world;
  return INSITU_MPI_OK;
}

static int reduce(insitu_mpi_world* world, int64_t* values, size_t count, int reduction,
                  char* message) {
  const MPI_Op op = reduction == INSITU_MPI_SUM     ? MPI_SUM
                    : reduction == INSITU_MPI_LEAST ? MPI_MIN
                                                    : MPI_MAX;
  const size_t most = longest / sizeof *values > 0 ? longest / sizeof *values : 1;
  int status = check_world(world, message);
  for (size_t i = 0; i < count && status == INSITU_MPI_OK; i += most) {
    const int now = (int)(count - i < most ? count - i : most);
    const int error =
        MPI_Allreduce(MPI_IN_PLACE, values + i, now, MPI_INT64_T, op, world->communicator);
    if (error != MPI_SUCCESS)
      status = failed("MPI_Allreduce", error, message);
  }
  return status;
}

static int broadcast(insitu_mpi_world* world, void* bytes, size_t size, int root, char* message) {
  int status = check_world(world, message);
  for (size_t i = 0; i < size && status == INSITU_MPI_OK; i += longest) {
    const int now = (int)(size - i < longest ? size - i : longest);
    const int error = MPI_Bcast((char*)bytes + i, now, MPI_BYTE, root, world->communicator);
    if (error != MPI_SUCCESS)
      status = failed("MPI_Bcast", error, message);
  }
  return status;
}

static int swap_numbers(insitu_mpi_world* world, const int64_t* to, int64_t* from, char* message) {
  const int status = check_world(world, message);
  if (status != INSITU_MPI_OK)
    return status;
  const int error =
      MPI_Alltoall((void*)(uintptr_t)to, 1, MPI_INT64_T, from, 1, MPI_INT64_T, world->communicator);
  return error == MPI_SUCCESS ? INSITU_MPI_OK : failed("MPI_Alltoall", error, message);
}

static size_t pieces_of(const insitu_mpi_part* parts, size_t count) {
  size_t pieces = 0;
  for (size_t i = 0; i < count; ++i)
    pieces += (parts[i].size + longest - 1) / longest;
  return pieces;
}

static int prepare(insitu_mpi_world* world, const insitu_mpi_part* out, size_t out_count,
                   const insitu_mpi_part* in, size_t in_count, char* message) {
  enum { at_once = 1 << 20 };
  const size_t most = pieces_of(in, in_count) + pieces_of(out, out_count);
  if (most > at_once)
    return fail(INSITU_MPI_FAILED, message, "more than 2^20 messages of a process at once");
  return make_room(world, most, message);
}

/* Messages between two processes keep their order, so one tag does for all. */
static int transfer(insitu_mpi_world* world, const insitu_mpi_part* out, size_t out_count,
                    const insitu_mpi_part* in, size_t in_count, char* message) {
  enum { tag = 1 };
  int status = check_world(world, message);
  MPI_Request* const requests = world->requests;
  size_t started = 0;
  for (int sends = 0; sends < 2 && status == INSITU_MPI_OK; ++sends) {
    const insitu_mpi_part* parts = sends ? out : in;
    const size_t count = sends ? out_count : in_count;
    for (size_t p = 0; p < count && status == INSITU_MPI_OK; ++p)
      for (size_t i = 0; i < parts[p].size && status == INSITU_MPI_OK; i += longest) {
        const int now = (int)(parts[p].size - i < longest ? parts[p].size - i : longest);
        char* bytes = (char*)parts[p].bytes + i;
        const int error = sends ? MPI_Isend(bytes, now, MPI_BYTE, parts[p].rank, tag,
                                            world->communicator, &requests[started])
                                : MPI_Irecv(bytes, now, MPI_BYTE, parts[p].rank, tag,
                                            world->communicator, &requests[started]);
        if (error != MPI_SUCCESS)
          status = failed(sends ? "MPI_Isend" : "MPI_Irecv", error, message);
        else
          ++started;
      }
  }
  const int error = MPI_Waitall((int)started, requests, MPI_STATUSES_IGNORE);
  if (status == INSITU_MPI_OK && error != MPI_SUCCESS)
    status = failed("MPI_Waitall", error, message);
  return status;
}

static size_t set_longest(size_t bytes) {
  const size_t before = longest;
  longest = bytes < 1 ? 1 : bytes > (size_t)1 << 30 ? (size_t)1 << 30 : bytes;
  return before;
}

const insitu_mpi_functions* insitu_mpi(void) {
  static const insitu_mpi_functions functions = {.version = INSITU_MPI_VERSION,
                                                 .open = open_world,
                                                 .check = check,
                                                 .close = close_world,
                                                 .wait_for_all = wait_for_all,
                                                 .reduce = reduce,
                                                 .broadcast = broadcast,
                                                 .swap_numbers = swap_numbers,
                                                 .prepare = prepare,
                                                 .transfer = transfer,
                                                 .set_longest = set_longest};
  return &functions;
}
