#include "parallel/mpi/functions.h"

#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>

struct insitu_mpi_world {
  MPI_Comm communicator; /* the session's own */
  int size;
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
  if (status == INSITU_MPI_OK)
    MPI_Comm_free(&world->communicator);
  free(world);
  return status;
}

static int open_world(const void* given, int fortran, insitu_mpi_world** made, int* rank, int* size,
                      int* on_this_node, int* single_threaded, char* message) {
  int status = check(message), inter = 0, error = MPI_SUCCESS, level = MPI_THREAD_SINGLE;
  MPI_Comm node = MPI_COMM_NULL;
  if (status != INSITU_MPI_OK)
    return status;
  const MPI_Comm communicator = given ? *(const MPI_Comm*)given : MPI_Comm_f2c((MPI_Fint)fortran);
  if (communicator == MPI_COMM_NULL)
    return fail(INSITU_MPI_ARGUMENT, message, "communicator: MPI_COMM_NULL");
  MPI_Comm_test_inter(communicator, &inter);
  if (inter)
    return fail(INSITU_MPI_ARGUMENT, message,
                "communicator: an intercommunicator, an intracommunicator expected");
  insitu_mpi_world* world = malloc(sizeof *world);
  if (!world)
    return fail(INSITU_MPI_FAILED, message, "out of memory");
  error = MPI_Comm_dup(communicator, &world->communicator);
  if (error != MPI_SUCCESS) {
    free(world);
    return failed("MPI_Comm_dup", error, message);
  }
  MPI_Comm_set_errhandler(world->communicator, MPI_ERRORS_RETURN);
  MPI_Comm_rank(world->communicator, rank);
  MPI_Comm_size(world->communicator, size);
  world->size = *size;
  *on_this_node = 1;
  error = MPI_Comm_split_type(world->communicator, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  if (error == MPI_SUCCESS && node != MPI_COMM_NULL) {
    MPI_Comm_size(node, on_this_node);
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
  int status = check(message);
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
  int status = check(message);
  for (size_t i = 0; i < size && status == INSITU_MPI_OK; i += longest) {
    const int now = (int)(size - i < longest ? size - i : longest);
    const int error = MPI_Bcast((char*)bytes + i, now, MPI_BYTE, root, world->communicator);
    if (error != MPI_SUCCESS)
      status = failed("MPI_Bcast", error, message);
  }
  return status;
}

static int swap_numbers(insitu_mpi_world* world, const int64_t* to, int64_t* from, char* message) {
  const int status = check(message);
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

/* Messages between two processes keep their order, so one tag does for all. */
static int transfer(insitu_mpi_world* world, const insitu_mpi_part* out, size_t out_count,
                    const insitu_mpi_part* in, size_t in_count, char* message) {
  enum { tag = 1, at_once = 1 << 20 };
  int status = check(message);
  if (status != INSITU_MPI_OK)
    return status;
  const size_t most = pieces_of(in, in_count) + pieces_of(out, out_count);
  if (most == 0)
    return INSITU_MPI_OK;
  if (most > at_once)
    return fail(INSITU_MPI_FAILED, message, "more than 2^20 messages of a process at once");
  MPI_Request* requests = malloc(most * sizeof *requests);
  if (!requests)
    return fail(INSITU_MPI_FAILED, message, "out of memory for MPI's requests");
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
  free(requests);
  return status;
}

static size_t set_longest(size_t bytes) {
  const size_t before = longest;
  longest = bytes < 1 ? 1 : bytes > (size_t)1 << 30 ? (size_t)1 << 30 : bytes;
  return before;
}

const insitu_mpi_functions* insitu_mpi(void) {
  static const insitu_mpi_functions functions = {INSITU_MPI_VERSION, open_world, check,
                                                 close_world,        reduce,     broadcast,
                                                 swap_numbers,       transfer,   set_longest};
  return &functions;
}
