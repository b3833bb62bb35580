/** @file query.h
 *  Queries: which cell owns a point, and what fields are there.
 *
 *  Any number of times after a commit, until the solver changes the arrays. The checked build (or
 *  INSITU_CHECKED=1 in the environment when the session is opened) answers a query, or a commit
 *  that was not told, by INSITU_ERROR_ORDER if coordinates, cells or ghosts are not what was
 *  committed; of an adaptive mesh with the first leaf that lies elsewhere, or the patch whose
 *  field's array has another shape. */
#ifndef INSITU_C_QUERY_H
#define INSITU_C_QUERY_H

#include "insitu/c/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What an answer is worth (and costs). All but INSITU_FAST by a ray method or on a device answer a
 *  cell that holds the point, by a certificate in floating point or else by exact arithmetic; the
 *  reasons tell which. Standard and exact differ only where cells of one piece overlap without
 *  folding: there standard may answer any cell that holds the point in its interior, always the
 * same one between two commits, and exact answers the lowest id (but see doc/design/tree.md for ray
 * methods where cells cross). */
typedef enum insitu_accuracy INSITU_INT {
  INSITU_FAST = 0,     /**< by a ray method or on a device: the papers' rules in float. Nothing is
                            proven; near faces another cell or none may answer, and its parametric
                            coordinates may lie outside of it. Else as standard */
  INSITU_STANDARD = 1, /**< a cell proven to hold the point answers alone */
  INSITU_EXACT = 2     /**< the lowest id of all that hold the point */
} insitu_accuracy;

/** Why a point has the owner that it has. */
typedef enum insitu_reason INSITU_INT {
  INSITU_REASON_OUTSIDE = 0,   /**< no cell that may own points holds it */
  INSITU_REASON_CERTIFIED = 1, /**< strictly inside its owner, proven in floating point */
  INSITU_REASON_EXACT = 2,     /**< strictly inside its owner, by exact arithmetic */
  INSITU_REASON_ON_FACE = 3,   /**< on a face of its owner, the lowest id of the cells there */
  INSITU_REASON_ON_EDGE = 4,   /**< the same, on an edge */
  INSITU_REASON_ON_VERTEX = 5, /**< the same, on a vertex */
  INSITU_REASON_COUNT = 6
} insitu_reason;

/** points: one array of 3 components, or three of 1 (float32 or float64). Outputs are the caller's,
 *  one item a point, in the points' order; each may be null. An output that shares memory with
 *  another, with the points, or with what the query reads of the mesh (coordinates, cells, ghosts,
 *  the fields sampled; where these have no gaps between their items) is INSITU_ERROR_ARGUMENT. */
typedef struct insitu_locate_args {
  size_t size;
  const insitu_array* points;
  int32_t point_arrays;
  const insitu_frame* frame; /**< of the points; null: the mesh's */
  insitu_accuracy accuracy;
  int64_t cell_base;  /**< 0 or 1: added to the cell ids */
  int64_t* cells;     /**< [count] owner, cell_base - 1 outside */
  int32_t* pieces;    /**< [count] its piece, -1 outside */
  double* parametric; /**< [count][3] VTK's parametric coordinates, NaN outside */
  uint8_t* found;     /**< [count] 1 inside */
  uint8_t* reasons;   /**< [count] why: an insitu_reason */
  /** Where all outputs lie, the values of a sample too, and the points. INSITU_DEVICE needs a
   * locator on a device, one packed float64 array of points, and no frame. */
  insitu_memory memory;
  /** INSITU_DEVICE: a cudaStream_t (null: the default stream), in whose order points are read and
   *  outputs written. The call waits, to learn which points need the host's exact arithmetic; in
   *  INSITU_FAST it does not, but when fields are asked for the first time after a commit. */
  void* stream;
  int64_t reserved[16]; /**< 0. insitu_sample_args holds it, so its size stays as it is */
} insitu_locate_args;

static inline insitu_locate_args insitu_locate_args_default(void) {
  insitu_locate_args a;
  int i;
  a.size = sizeof a;
  a.points = NULL;
  a.point_arrays = 1;
  a.frame = NULL;
  a.accuracy = INSITU_STANDARD;
  a.cell_base = 0;
  a.cells = NULL;
  a.pieces = NULL;
  a.parametric = NULL;
  a.found = NULL;
  a.reasons = NULL;
  a.memory = INSITU_HOST;
  a.stream = NULL;
  for (i = 0; i < 16; ++i)
    a.reserved[i] = 0;
  return a;
}

/** Which cell owns each point. Of the closed cells that hold a point, the lowest (piece, cell)
 *  owns it (for standard see insitu_accuracy); ghost cells own nothing. NaN and infinite points are
 *  outside. */
INSITU_API insitu_status insitu_mesh_locate(insitu_mesh mesh, const insitu_locate_args* args);

typedef struct insitu_sample_args {
  size_t size;
  insitu_locate_args locate; /**< the points and, if wanted, where they lie */
  const char* const* fields; /**< [field_count] names */
  int32_t field_count;
  double* const* values; /**< [field_count] outputs, each [count][components of the field] */
} insitu_sample_args;

static inline insitu_sample_args insitu_sample_args_default(void) {
  insitu_sample_args a;
  a.size = sizeof a;
  a.locate = insitu_locate_args_default();
  a.fields = NULL;
  a.field_count = 0;
  a.values = NULL;
  return a;
}

/** Locates and interpolates several fields at once: vertex fields by the cell's shape functions,
 *  cell fields by the owner's value. Outside: a quiet NaN, and found is 0. */
INSITU_API insitu_status insitu_mesh_sample(insitu_mesh mesh, const insitu_sample_args* args);

/** One point (in the mesh's frame), one field: values has room for the field's components.
 *  *found may be null. */
INSITU_API insitu_status insitu_mesh_sample_point(insitu_mesh mesh, const char* field,
                                                  const double point[3], double* values,
                                                  int32_t* found);

/** The components of a field, and its association; outputs may be null. */
INSITU_API insitu_status insitu_mesh_field_info(insitu_mesh mesh, const char* name,
                                                int32_t* components,
                                                insitu_association* association);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_QUERY_H */
