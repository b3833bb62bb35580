/** @file commit.h
 *  A commit brings the library's structures up to date; validation and the copy audit check what
 *  the caller gave. */
#ifndef INSITU_C_COMMIT_H
#define INSITU_C_COMMIT_H

#include "insitu/c/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What changed since the last commit. Values combine with |. */
enum {
  INSITU_CHANGED_NOTHING = 0,
  INSITU_CHANGED_FIELDS = 1,   /**< values of fields changed */
  INSITU_CHANGED_GEOMETRY = 2, /**< coordinates of vertices changed */
  INSITU_CHANGED_TOPOLOGY = 4, /**< cells, pieces or ghost bits changed (implies geometry and
                                    fields) */
  INSITU_CHANGED_ALL = 7
};

/** Tells the library what changed since the last commit (INSITU_CHANGED_*). Calls add up until the
 *  commit. A call that gives a new array or cells implies it. */
INSITU_API insitu_status insitu_mesh_changed(insitu_mesh mesh, uint32_t what);

/** Says that the caller cannot give the mesh's arrays, and why: the mesh is not committed any more,
 *  and until a call with a null message takes that back its commits, those of
 *  insitu_session_execute among them, read no array and fail with INSITU_ERROR_MESH and this
 *  message. Over several processes all of them then get this error, which names the process, and
 *  none waits for it. */
INSITU_API insitu_status insitu_mesh_refuse(insitu_mesh mesh, const char* message);

typedef enum insitu_action INSITU_INT {
  INSITU_KEEP = 0,   /**< the commit had nothing to do, or refreshed value ranges */
  INSITU_REFIT = 1,  /**< vertices moved: boxes are refitted, once a query asks the tree */
  INSITU_REBUILD = 2 /**< the commit built the tree anew */
} insitu_action;

/** How the tree that answers queries was built. */
typedef enum insitu_builder INSITU_INT {
  INSITU_BUILDER_NONE = 0,        /**< there is no tree: no cell may own points */
  INSITU_BUILDER_MORTON = 1,      /**< in Morton order, which is fast */
  INSITU_BUILDER_SURFACE_AREA = 2 /**< by surface area, which takes longer to build and less to
                                       query */
} insitu_builder;

typedef struct insitu_commit_report {
  size_t size;
  insitu_action action;
  int32_t validated; /**< 1 if this commit validated the mesh, else 0 */
  double seconds;
  int64_t cells;
  int64_t vertices;
  int64_t bytes;           /**< bytes that the mesh's structures hold after the commit */
  int64_t bytes_allocated; /**< bytes that this commit newly allocated */
  double cost_ratio;       /**< cost of the refitted tree over the cost of the last build, as of the
                                last refit; 1 after a build */
  insitu_builder builder;  /**< how the tree that answers after the commit was built */
  int32_t reserved;
} insitu_commit_report;

static inline insitu_commit_report insitu_commit_report_default(void) {
  insitu_commit_report r;
  r.size = sizeof r;
  r.action = INSITU_KEEP;
  r.validated = 0;
  r.seconds = 0.0;
  r.cells = r.vertices = r.bytes = r.bytes_allocated = 0;
  r.cost_ratio = 1.0;
  r.builder = INSITU_BUILDER_NONE;
  r.reserved = 0;
  return r;
}

/** Brings the structures up to date. After a change of topology the commit rebuilds; after a change
 *  of geometry it notes that the tree is to be refitted, or rebuilt once the refitted tree costs
 *  too much: the first query that asks the tree does so (insitu_mesh_complete does so now), and
 *  points that are found in the cell that held them before ask it for nothing. In a session of
 *  several processes a rebuild is put off likewise, and the report's bytes then are without the
 *  tree. Ray methods, devices and geodetic meshes refit in the commit. After a change of fields a
 *  commit refreshes value ranges; without a change it does nothing. Once queries and tracers, but
 *  not frames, have located enough points, a commit of geometry or fields also rebuilds by
 *  surface area. The mesh's first commit validates the mesh, and so does a commit after a change of
 *  topology. report may be null. Where a device answers (insitu_mesh_locator), the commit waits for
 *  all work that was queued on the device, on any stream: queries and tracers may still read what
 *  changes, and the solver may still write it. INSITU_ERROR_MESH: validation refused the mesh.
 *  INSITU_ERROR_FIELD: a field does not fit. */
INSITU_API insitu_status insitu_mesh_commit(insitu_mesh mesh, insitu_commit_report* report);

/** Does now what the last commit has put off until a query needs it: the tree's refit, or its
 *  rebuild. Answers are the same with and without this call; it chooses when the time is spent, and
 *  where want of memory is told: without it, the query that needed the work returns
 *  INSITU_ERROR_MEMORY, and the next one tries again. report may be null; its action says what was
 *  done, INSITU_KEEP if nothing was left to do. INSITU_ERROR_ORDER: the mesh is not committed. */
INSITU_API insitu_status insitu_mesh_complete(insitu_mesh mesh, insitu_commit_report* report);

/** What validation found, as counts by kind. Errors refuse a mesh; warnings are only counted. */
typedef struct insitu_validation {
  size_t size;
  int64_t cells;
  int64_t index_errors;      /**< ids out of range, of cells or faces */
  int64_t shape_errors;      /**< cells of unknown shapes or with wrong numbers of ids, offsets out
                                  of order, faces that bound no cell */
  int64_t coordinate_errors; /**< vertices, used by a cell, that are NaN or infinite */
  int64_t inverted_cells;    /**< warning: volume < 0 */
  int64_t zero_volume_cells; /**< warning: volume 0 to rounding */
  int64_t folded_cells;      /**< warning: the map's Jacobian changes sign somewhere in the cell */
  int64_t collapsed_cells;   /**< warning: two vertices of a cell coincide */
  int64_t ghost_cells;
  /* What does not conform between cells, counted if there are no errors. A point at such a place
   * still belongs to the lowest of the cells that hold it, and a point in a gap between cells is
   * outside. */
  int64_t coincident_vertices; /**< vertices at the place of another vertex, bit for bit, as along
                                    seams. The library matches faces by place, so these vertices
                                    alone lose no point and double none */
  int64_t crowded_faces;       /**< faces of three cells or more, which overlap */
  int64_t split_faces;         /**< quads against two triangles, or against a quad of the same
                                    corners in another order: both cells, or neither, hold the
                                    sliver between */
  int64_t hanging_vertices; /**< vertices on a face or edge of a cell that has no corner there, to
                                 1e-9 of the cell */
  int64_t covered_vertices; /**< vertices in the interior of a cell, where cells overlap */
} insitu_validation;

static inline insitu_validation insitu_validation_default(void) {
  insitu_validation v;
  v.size = sizeof v;
  v.cells = v.index_errors = v.shape_errors = v.coordinate_errors = v.inverted_cells = 0;
  v.zero_volume_cells = v.folded_cells = v.collapsed_cells = v.ghost_cells = 0;
  v.coincident_vertices = v.crowded_faces = v.split_faces = 0;
  v.hanging_vertices = v.covered_vertices = 0;
  return v;
}

/** Validates the arrays as they are now, and compares faces with each other, which a commit does
 *  not. INSITU_ERROR_MESH: a commit would refuse the mesh; the message gives the first findings.
 *  The call writes the counts in either case. validation may be null. */
INSITU_API insitu_status insitu_mesh_validate(insitu_mesh mesh, insitu_validation* validation);

/** One line of the copy audit. Entries come as a list, so the size of this struct stays as it
 *  is. */
typedef struct insitu_audit_entry {
  size_t size;
  char name[64];    /**< name of the array, such as "piece 0 points x" or "piece 0 field 'velocity'
                         component 1" */
  const void* data; /**< the pointer that the kernels read */
  int64_t bytes;    /**< bytes of the array's items */
  int32_t borrowed; /**< 1: the caller's memory in place; 0: a converted copy */
  char reason[64];  /**< why the array was converted, if it was */
  int32_t reserved[9];
} insitu_audit_entry;

/** Writes the copy audit. *count is the room in entries before the call, and the number of arrays
 *  after it. entries may be null, in order to ask for that number alone. */
INSITU_API insitu_status insitu_mesh_audit(insitu_mesh mesh, insitu_audit_entry* entries,
                                           int32_t* count);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_COMMIT_H */
