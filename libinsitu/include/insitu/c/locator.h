/** @file locator.h
 *  A locator says by which method, and where, points find their cells.
 *
 *  All locators give the same owners in INSITU_EXACT; they differ in time and memory. */
#ifndef INSITU_C_LOCATOR_H
#define INSITU_C_LOCATOR_H

#include "insitu/c/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How points find their cells. The ray methods are those of Morrical 2020. The backends of each
 *  method stand after it. */
typedef enum insitu_method INSITU_INT {
  INSITU_METHOD_AUTO = 0,                 /**< the library chooses, and says what it chose */
  INSITU_METHOD_BVH = 1,                  /**< a tree of the cells' boxes; cpu, cuda */
  INSITU_METHOD_USER_GEOMETRY = 2,        /**< cells as primitives, found by vanishing rays; cpu,
                                               optix */
  INSITU_METHOD_REPLICATED_FACES = 3,     /**< each cell's own triangles, found by short rays; cpu,
                                               optix */
  INSITU_METHOD_SHARED_FACES = 4,         /**< each face once, found by short rays; cpu, optix */
  INSITU_METHOD_SHARED_BILINEAR_FACES = 5 /**< each face once, curved quads in their tetrahedra,
                                               found by short rays; cpu, optix */
} insitu_method;

/** Where queries are answered. */
typedef enum insitu_backend INSITU_INT {
  INSITU_BACKEND_AUTO = 0, /**< the device if the mesh lies there; otherwise, for ray methods, OptiX
                                if it can be used; otherwise the CPU */
  INSITU_BACKEND_CPU = 1,  /**< the library's own tree, or Embree for ray methods */
  INSITU_BACKEND_CUDA = 2, /**< a build with CUDA, on a card */
  INSITU_BACKEND_OPTIX = 3 /**< a build with OptiX, on a card whose driver supports it */
} insitu_backend;

typedef struct insitu_locator {
  size_t size;
  insitu_method method;
  insitu_backend backend;
} insitu_locator;

static inline insitu_locator insitu_locator_default(void) {
  insitu_locator l;
  l.size = sizeof l;
  l.method = INSITU_METHOD_AUTO;
  l.backend = INSITU_BACKEND_AUTO;
  return l;
}

/** Chooses the mesh's locator, in place of the scene's choice. The next commit makes the locator,
 *  at a cost as after a change of topology. locator null takes the scene's choice again.
 *  INSITU_ERROR_UNSUPPORTED: an explicit choice cannot be had, and nothing changes; the message
 *  says why ("driver too old for this OptiX (ABI 105)", "built without CUDA"). */
INSITU_API insitu_status insitu_mesh_locator(insitu_mesh mesh, const insitu_locator* locator);

/** What answers queries since the last commit, and how it decided points. */
typedef struct insitu_locator_info {
  size_t size;
  insitu_method method;
  insitu_backend backend;
  char reason[128];   /**< why this method and backend, in words */
  int64_t primitives; /**< number of cells, or of triangles of the face methods */
  int64_t bytes;      /**< bytes that the method's structures hold, the tree and the device's copies
                           included */
  int64_t bytes_peak; /**< the most bytes that they held during their last build */
  int64_t bytes_copied; /**< bytes of copies of host arrays on the device */
  /* The four counts below are of points, since the mesh was made, in batches by a ray method or on
   * a device. Points of INSITU_FAST are not counted: it takes the ray's cell unproven. */
  int64_t kept;            /**< points answered by the cell that the ray told, once it was
                                certified */
  int64_t by_neighbour;    /**< points answered by the cell across the face that the ray hit; a
                                device counts them in kept */
  int64_t by_tree;         /**< points answered by the tree: the fallback of ray methods, and all
                                points of `bvh` */
  int64_t settled_on_host; /**< points that a device left undecided, and that exact arithmetic on
                                the host decided */
} insitu_locator_info;

static inline insitu_locator_info insitu_locator_info_default(void) {
  insitu_locator_info i;
  int k;
  i.size = sizeof i;
  i.method = INSITU_METHOD_AUTO;
  i.backend = INSITU_BACKEND_AUTO;
  for (k = 0; k < 128; ++k)
    i.reason[k] = 0;
  i.primitives = i.bytes = i.bytes_peak = i.bytes_copied = 0;
  i.kept = i.by_neighbour = i.by_tree = i.settled_on_host = 0;
  return i;
}

/** Writes what answers queries. INSITU_ERROR_ORDER: the mesh has no commit yet. */
INSITU_API insitu_status insitu_mesh_locator_info(insitu_mesh mesh, insitu_locator_info* info);

/** Particles in device memory, and how to move them. positions, cells and endings are the
 *  caller's. */
typedef struct insitu_advance_args {
  size_t size;
  const char* velocity; /**< name of a field of 3 components, taken as steady */
  double* positions;    /**< [count][3], in the mesh's frame; moved in place */
  uint32_t* cells;      /**< [count] the library's record of where particles are; the caller sets
                             0xffffffff at first, and after a change of topology */
  uint8_t* endings;     /**< [count] an insitu_ending each; particles that are INSITU_END_ALIVE are
                             moved */
  int64_t count;
  double step;   /**< time of one step; negative: backwards */
  int64_t steps; /**< number of steps */
  void* stream;  /**< a cudaStream_t; null: the default stream */
} insitu_advance_args;

static inline insitu_advance_args insitu_advance_args_default(void) {
  insitu_advance_args a;
  a.size = sizeof a;
  a.velocity = NULL;
  a.positions = NULL;
  a.cells = NULL;
  a.endings = NULL;
  a.count = 0;
  a.step = 0.0;
  a.steps = 1;
  a.stream = NULL;
  return a;
}

/** Moves particles by steps of Kutta's fourth order, on the device that answers the mesh's queries;
 *  the work is queued on the stream. A particle that a step would take out of the mesh, or to a
 *  velocity that is not finite, ends where it was before that step. INSITU_ERROR_UNSUPPORTED: the
 *  mesh's locator is on the CPU, where a scene's tracers run instead. */
INSITU_API insitu_status insitu_mesh_advance(insitu_mesh mesh, const insitu_advance_args* args);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_LOCATOR_H */
