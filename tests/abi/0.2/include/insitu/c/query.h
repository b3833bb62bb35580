/** @file query.h
 *  Queries tell which cell owns a point, and what values fields have there.
 *
 *  After a commit the caller may make any number of queries, until the solver changes the arrays.
 *  The checked build (or INSITU_CHECKED=1 in the environment when the session is opened) compares
 *  the mesh with what was committed: a query, and a commit that was not told of the change, return
 *  INSITU_ERROR_ORDER if coordinates, cells or ghosts are others; on an adaptive mesh the message
 *  names the first leaf that lies elsewhere, or the patch whose field's array has another shape. */
#ifndef INSITU_C_QUERY_H
#define INSITU_C_QUERY_H

#include "insitu/c/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What an answer is worth, and costs. Every query but one of INSITU_FAST by a ray method or on a
 *  device answers a cell that holds the point, by a certificate in floating point or else by exact
 *  arithmetic; the reasons tell which. INSITU_STANDARD and INSITU_EXACT differ only where cells of
 *  one piece overlap without folding: there INSITU_STANDARD may answer any cell that holds the
 *  point in its interior, always the same one between two commits, and INSITU_EXACT answers the
 *  lowest id (but see doc/design/tree.md for ray methods where cells cross). */
typedef enum insitu_accuracy INSITU_INT {
  INSITU_FAST = 0,     /**< By a ray method or on a device: the rules of the methods' papers, in
                            float. Nothing is proven; near faces another cell or none may answer,
                            and the parametric coordinates may lie outside of the cell. Elsewhere
                            the same as INSITU_STANDARD */
  INSITU_STANDARD = 1, /**< a cell proven to hold the point answers alone */
  INSITU_EXACT = 2     /**< the lowest id of all cells that hold the point */
} insitu_accuracy;

/** Why a point has the owner that it has. */
typedef enum insitu_reason INSITU_INT {
  INSITU_REASON_OUTSIDE = 0,   /**< no cell that may own points holds the point */
  INSITU_REASON_CERTIFIED = 1, /**< the point lies strictly inside its owner, as proven in floating
                                    point */
  INSITU_REASON_EXACT = 2,     /**< the point lies strictly inside its owner, by exact arithmetic */
  INSITU_REASON_ON_FACE = 3,   /**< on a face of its owner, which is the lowest id of the cells
                                    there */
  INSITU_REASON_ON_EDGE = 4,   /**< on an edge of its owner, chosen likewise */
  INSITU_REASON_ON_VERTEX = 5, /**< on a vertex of its owner, chosen likewise */
  INSITU_REASON_COUNT = 6
} insitu_reason;

/** Whose cells may hold the points of a query. */
typedef enum insitu_scope INSITU_INT {
  INSITU_SCOPE_LOCAL = 0,     /**< this process's; the call is this process's alone */
  INSITU_SCOPE_EVERYWHERE = 1 /**< those of all processes of the session. The call is collective:
                                   all processes make it with the same fields and accuracy, each
                                   with points of its own, or with none. Of the cells that hold a
                                   point the one with the lowest global id answers
                                   (insitu_mesh_global_ids); without global ids the lowest
                                   (process, piece, cell). The processes' meshes are committed */
} insitu_scope;

/** What a query answers for a point that no cell holds. */
typedef enum insitu_outside INSITU_INT {
  INSITU_OUTSIDE_NONE = 0,   /**< no cell */
  INSITU_OUTSIDE_NEAREST = 1 /**< the nearest cell that may own points, and the point of it that is
                                  nearest: the cell's ids, the parametric coordinates and the values
                                  there. Of cells at one distance the one with the lowest id
                                  answers. found stays 0. In a geodetic frame nearness is measured
                                  in metres, by the lengths of a degree at the point
                                  (doc/guide/nearest.md). On the host */
} insitu_outside;

/** Arguments of insitu_mesh_locate. points: one array of 3 components, or three arrays of 1
 *  (float32 or float64). Outputs are memory of the caller, one item a point, in the points' order;
 *  each may be null, and is then left out. INSITU_ERROR_ARGUMENT: an output shares memory with
 *  another output, with the points, or with what the query reads of the mesh (coordinates, cells,
 *  ghosts, and the fields sampled, as far as these have no gaps between their items). */
typedef struct insitu_locate_args {
  size_t size;
  const insitu_array* points;
  int32_t point_arrays;      /**< 1 or 3; or INSITU_LACKS_MEMORY */
  const insitu_frame* frame; /**< frame of the points; null: the mesh's */
  insitu_accuracy accuracy;
  int64_t cell_base;  /**< 0 or 1, which is added to the cell ids */
  int64_t* cells;     /**< [count] the owner's id; cell_base - 1 outside */
  int32_t* pieces;    /**< [count] the owner's piece; -1 outside */
  double* parametric; /**< [count][3] VTK's parametric coordinates in the owner; NaN outside,
                           and in a polyhedron that is none of the shapes (insitu_faces) */
  uint8_t* found;     /**< [count] 1 inside, 0 outside */
  uint8_t* reasons;   /**< [count] an insitu_reason: why the point has this owner */
  /** Where the points and all outputs lie, the values of a sample too. INSITU_DEVICE needs a
   *  locator on a device, one packed float64 array of points, and no frame. */
  insitu_memory memory;
  /** A cudaStream_t for INSITU_DEVICE (null: the default stream), in whose order the device reads
   *  points and writes outputs. The call waits, to learn which points need the host's exact
   *  arithmetic. In INSITU_FAST it waits only when fields are asked for the first time after a
   *  commit. */
  void* stream;
  insitu_scope scope; /**< INSITU_SCOPE_EVERYWHERE: on the host */
  int32_t padding;    /**< always 0 */
  int32_t* ranks;     /**< [count] the owner's process in the session's communicator; -1 outside */
  int64_t* global_cells;  /**< [count] the owner's global id; -1 outside, and where the solver gives
                               none */
  insitu_outside outside; /**< what points outside get */
  int32_t padding_outside;  /**< always 0 */
  double greatest_distance; /**< for INSITU_OUTSIDE_NEAREST: cells farther than that do not answer;
                                 0: any distance */
  double* distances; /**< [count] distance from the point to the cell that answers, in the mesh's
                          units, in metres of a geodetic mesh; 0 inside, NaN without an answer */
  double* nearest; /**< [count][3] the nearest point of the cell that answers, in the mesh's frame;
                        the point itself inside, NaN without an answer */
  int64_t reserved[9]; /**< always 0. insitu_sample_args holds this struct, so its size stays as
                             it is */
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
  a.scope = INSITU_SCOPE_LOCAL;
  a.padding = 0;
  a.ranks = NULL;
  a.global_cells = NULL;
  a.outside = INSITU_OUTSIDE_NONE;
  a.padding_outside = 0;
  a.greatest_distance = 0.0;
  a.distances = NULL;
  a.nearest = NULL;
  for (i = 0; i < 9; ++i)
    a.reserved[i] = 0;
  return a;
}

/** Finds the cell that owns each point. Of the closed cells that hold a point, the lowest
 *  (piece, cell) owns it (insitu_accuracy tells where INSITU_STANDARD may differ); ghost cells own
 *  nothing. NaN and infinite points are outside. */
INSITU_API insitu_status insitu_mesh_locate(insitu_mesh mesh, const insitu_locate_args* args);

typedef struct insitu_sample_args {
  size_t size;
  insitu_locate_args locate; /**< the points and, if wanted, where they lie */
  const char* const* fields; /**< [field_count] names of fields */
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

/** Locates points and interpolates several fields at once: vertex fields by the cell's shape
 *  functions, cell fields by the owner's value. A point that is outside gets a quiet NaN, and found
 *  0. */
INSITU_API insitu_status insitu_mesh_sample(insitu_mesh mesh, const insitu_sample_args* args);

/** Samples one field at one point in the mesh's frame. values has room for the field's components.
 *  found may be null; *found is 1 inside, 0 outside. */
INSITU_API insitu_status insitu_mesh_sample_point(insitu_mesh mesh, const char* field,
                                                  const double point[3], double* values,
                                                  int32_t* found);

/** Arguments of insitu_mesh_nearest_vertices. Outputs are memory of the caller, of nearest items a
 *  point, in order of distance and, at one distance, of ids; each may be null. */
typedef struct insitu_vertices_args {
  size_t size;
  const insitu_array* points; /**< as for insitu_locate_args */
  int32_t point_arrays;
  int32_t nearest;           /**< how many vertices a point asks for, at least 1 */
  const insitu_frame* frame; /**< frame of the points; null: the mesh's */
  double greatest_distance;  /**< vertices farther than that are left out; 0: any distance */
  insitu_scope scope;
  int32_t vertex_base; /**< 0 or 1, which is added to the vertex ids */
  int64_t* vertices;   /**< [count][nearest] ids; vertex_base - 1 where there are no more */
  int32_t* pieces;     /**< [count][nearest] -1 where there are no more */
  int32_t* ranks;      /**< [count][nearest] processes in the session's communicator; -1 where there
                            are no more */
  int64_t* global_vertices; /**< [count][nearest] global ids; -1 where there are no more, and where
                                 the solver gives none */
  double* distances;        /**< [count][nearest] NaN where there are no more */
  double* places;           /**< [count][nearest][3] the vertices' coordinates in the mesh's frame;
                                 NaN where there are no more */
} insitu_vertices_args;

static inline insitu_vertices_args insitu_vertices_args_default(void) {
  insitu_vertices_args a;
  a.size = sizeof a;
  a.points = NULL;
  a.point_arrays = 1;
  a.nearest = 1;
  a.frame = NULL;
  a.greatest_distance = 0.0;
  a.scope = INSITU_SCOPE_LOCAL;
  a.vertex_base = 0;
  a.vertices = NULL;
  a.pieces = a.ranks = NULL;
  a.global_vertices = NULL;
  a.distances = a.places = NULL;
  return a;
}

/** Finds the vertices nearest to each point, of all vertices of cells that may own points. Vertices
 *  with one global id count once; without global ids a vertex counts once in each piece. Distances
 *  are those of insitu_locate_args. */
INSITU_API insitu_status insitu_mesh_nearest_vertices(insitu_mesh mesh,
                                                      const insitu_vertices_args* args);

/** Writes the number of components of a field, and its association; each output may be null. */
INSITU_API insitu_status insitu_mesh_field_info(insitu_mesh mesh, const char* name,
                                                int32_t* components,
                                                insitu_association* association);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_QUERY_H */
