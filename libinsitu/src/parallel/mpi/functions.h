/* What libinsitu-mpi gives to libinsitu, which loads it when a session is given a communicator:
 * serial programs never load MPI. Both libraries are of one version. Each function returns 0, or
 * another number with a message. */
#ifndef INSITU_PARALLEL_MPI_FUNCTIONS_H
#define INSITU_PARALLEL_MPI_FUNCTIONS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { INSITU_MPI_VERSION = 4, INSITU_MPI_MESSAGE = 1024 };
enum { INSITU_MPI_SUM, INSITU_MPI_LEAST, INSITU_MPI_GREATEST };
enum {
  INSITU_MPI_OK,
  INSITU_MPI_FAILED,   /* MPI said so */
  INSITU_MPI_ORDER,    /* MPI is not initialised yet, or finalised already */
  INSITU_MPI_ARGUMENT, /* what is given is no communicator to work on */
  INSITU_MPI_THREAD,   /* not the thread that may call MPI */
  INSITU_MPI_MEMORY    /* a process lacks memory */
};

typedef struct insitu_mpi_world insitu_mpi_world;

typedef struct insitu_mpi_part {
  int rank;
  void* bytes; /* of what is sent they are only read */
  size_t size;
} insitu_mpi_part;

typedef struct insitu_mpi_functions {
  int version;
  /* Duplicates the communicator at an address, or with none that of a Fortran integer; collective
   * over it. lacks: the caller has no memory for its part. If any process has none, all say so
   * alike. seconds: how long those that came wait for the others; 0: without end. *rank is known in
   * any case, or -1. cores_here: of this node, those that any of its processes may use. */
  int (*open)(const void* communicator, int fortran_communicator, int lacks, double seconds,
              insitu_mpi_world** world, int* rank, int* size, int* on_this_node, int* cores_here,
              int* single_threaded, char* message);
  /* Whether MPI may be called now, by this thread; not collective. */
  int (*check)(char* message);
  /* Frees the communicator unless MPI is finalised; collective. */
  int (*close)(insitu_mpi_world* world, char* message);
  /* See World::wait_for_all; *missing is -1 where all came. */
  int (*wait_for_all)(insitu_mpi_world* world, double seconds, int* missing, char* message);
  int (*reduce)(insitu_mpi_world* world, int64_t* values, size_t count, int reduction,
                char* message);
  int (*broadcast)(insitu_mpi_world* world, void* bytes, size_t size, int root, char* message);
  /* A number to and from each process. */
  int (*swap_numbers)(insitu_mpi_world* world, const int64_t* to, int64_t* from, char* message);
  /* Takes memory for the transfer of these parts; not collective. */
  int (*prepare)(insitu_mpi_world* world, const insitu_mpi_part* out, size_t out_count,
                 const insitu_mpi_part* in, size_t in_count, char* message);
  /* Of what was prepared. */
  int (*transfer)(insitu_mpi_world* world, const insitu_mpi_part* out, size_t out_count,
                  const insitu_mpi_part* in, size_t in_count, char* message);
  /* Messages of more bytes than this go in pieces; returns what it was. At most 2^30, as it is
   * unless a test lowers it. */
  size_t (*set_longest)(size_t bytes);
} insitu_mpi_functions;

/* The one symbol of the library. */
const insitu_mpi_functions* insitu_mpi(void);

#ifdef __cplusplus
}
#endif

#endif
