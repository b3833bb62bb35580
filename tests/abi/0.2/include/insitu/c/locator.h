/** @file locator.h
 *  Locators: by which method, and where, points find their cells.
 *
 *  All give the same owners in INSITU_EXACT; they differ in time and memory. */
#ifndef INSITU_C_LOCATOR_H
#define INSITU_C_LOCATOR_H

#include "insitu/c/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How points find their cells. The ray methods are those of Morrical 2020. */
typedef enum insitu_method INSITU_INT {
  INSITU_METHOD_AUTO = 0,                 /**< the library chooses, and says what */
  INSITU_METHOD_BVH = 1,                  /**< a tree of the cells' boxes; cpu, cuda */
  INSITU_METHOD_USER_GEOMETRY = 2,        /**< cells as primitives, vanishing rays; cpu, optix */
  INSITU_METHOD_REPLICATED_FACES = 3,     /**< each cell's own triangles, short rays; cpu, optix */
  INSITU_METHOD_SHARED_FACES = 4,         /**< each face once, short rays; cpu, optix */
  INSITU_METHOD_SHARED_BILINEAR_FACES = 5 /**< the same, curved quads in their tetrahedra */
} insitu_method;

/** Where queries are answered. */
typedef enum insitu_backend INSITU_INT {
  INSITU_BACKEND_AUTO = 0, /**< the device if the mesh lies there; for ray methods OptiX if it can
                              be used; else the CPU */
  INSITU_BACKEND_CPU = 1,  /**< our tree, and Embree for ray methods */
  INSITU_BACKEND_CUDA = 2, /**< needs a build with CUDA, and a card */
  INSITU_BACKEND_OPTIX = 3 /**< needs a build with OptiX, and a card and driver for it */
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

/** Chooses the mesh's locator; the next commit makes it (at a cost as after a change of topology).
 * It goes before the scene's. INSITU_ERROR_UNSUPPORTED, and nothing changes, if an explicit choice
 * cannot be had: the message says why ("driver too old for this OptiX (ABI 105)", "built without
 * CUDA"). locator null: the scene's again. */
INSITU_API insitu_status insitu_mesh_locator(insitu_mesh mesh, const insitu_locator* locator);

/** What answers queries since the last commit, and how they were decided. */
typedef struct insitu_locator_info {
  size_t size;
  insitu_method method;
  insitu_backend backend;
  char reason[128];   /**< why these, in words */
  int64_t primitives; /**< cells, or triangles of the face methods */
  int64_t bytes; /**< held by the method's structures, the tree and the device's copies included */
  int64_t bytes_peak;   /**< the most during their last build */
  int64_t bytes_copied; /**< of host arrays, on the device */
  /* Points, since the mesh was made, of batches by a ray method or on a device. INSITU_FAST counts
     none: it takes the ray's cell unproven. */
  int64_t kept;            /**< answered by the cell that the ray told, once certified */
  int64_t by_neighbour;    /**< by the cell across the face that the ray hit; on a device in kept */
  int64_t by_tree;         /**< by the tree: the fallback of ray methods, all points of `bvh` */
  int64_t settled_on_host; /**< left undecided by a device; exact arithmetic on the host */
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

/** INSITU_ERROR_ORDER before the first commit. */
INSITU_API insitu_status insitu_mesh_locator_info(insitu_mesh mesh, insitu_locator_info* info);

/** Particles in device memory, and how to move them. */
typedef struct insitu_advance_args {
  size_t size;
  const char* velocity; /**< a field of 3 components, taken as steady */
  double* positions;    /**< [count][3], in the mesh's frame; moved in place */
  uint32_t* cells;  /**< [count] where they are, for the library: 0xffffffff at first, and after a
                         change of topology */
  uint8_t* endings; /**< [count] an insitu_ending; those INSITU_END_ALIVE are moved */
  int64_t count;
  double step;   /**< of time; negative: backwards */
  int64_t steps; /**< so many */
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
 *  queued on the stream. A particle that a step would take out of the mesh, or to a velocity that
 * is not finite, ends where it was before that step. INSITU_ERROR_UNSUPPORTED with a locator on the
 *  CPU: a scene's tracers run there. */
INSITU_API insitu_status insitu_mesh_advance(insitu_mesh mesh, const insitu_advance_args* args);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_LOCATOR_H */
