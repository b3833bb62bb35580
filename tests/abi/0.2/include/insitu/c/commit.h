/** @file commit.h
 *  Commits: bringing the library's structures up to date; validation and the copy audit. */
#ifndef INSITU_C_COMMIT_H
#define INSITU_C_COMMIT_H

#include "insitu/c/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What changed since the last commit; combine with |. */
enum {
  INSITU_CHANGED_NOTHING = 0,
  INSITU_CHANGED_FIELDS = 1,   /**< field values */
  INSITU_CHANGED_GEOMETRY = 2, /**< vertex coordinates */
  INSITU_CHANGED_TOPOLOGY = 4, /**< cells, pieces, ghost bits (implies geometry and fields) */
  INSITU_CHANGED_ALL = 7
};

/** Says what changed since the last commit (INSITU_CHANGED_*); adds up until the commit. Giving
 *  a new array or cells says so by itself. */
INSITU_API insitu_status insitu_mesh_changed(insitu_mesh mesh, uint32_t what);

typedef enum insitu_action INSITU_INT {
  INSITU_KEEP = 0,   /**< nothing had to be done, or value ranges were refreshed */
  INSITU_REFIT = 1,  /**< boxes were refitted to moved vertices */
  INSITU_REBUILD = 2 /**< the tree was built anew */
} insitu_action;

/** How the tree that answers was built. */
typedef enum insitu_builder INSITU_INT {
  INSITU_BUILDER_NONE = 0,        /**< there is none: no cell may own points */
  INSITU_BUILDER_MORTON = 1,      /**< in Morton order: fast */
  INSITU_BUILDER_SURFACE_AREA = 2 /**< by surface area: dearer, and cheaper to ask */
} insitu_builder;

typedef struct insitu_commit_report {
  size_t size;
  insitu_action action;
  int32_t validated; /**< 1 if this commit validated the mesh */
  double seconds;
  int64_t cells;
  int64_t vertices;
  int64_t bytes;           /**< held by the mesh's structures after the commit */
  int64_t bytes_allocated; /**< newly allocated by this commit */
  double cost_ratio;      /**< cost of the refitted tree over that of the last build (1 if built) */
  insitu_builder builder; /**< of the tree that answers after the commit */
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

/** Brings the structures up to date: topology -> rebuild; geometry -> refit, or rebuild once the
 *  refitted tree costs too much; fields -> value ranges; nothing -> nothing. Once enough points
 *  were located, by others than frames, geometry or fields also rebuild by surface area. The first
 *  commit validates the mesh, and so does one after a change of topology. report may be null.
 *  Where a device answers (insitu_mesh_locator), a commit waits for all work that was queued on the
 *  device, on any stream: queries and tracers may still read what changes, and the solver write it.
 */
INSITU_API insitu_status insitu_mesh_commit(insitu_mesh mesh, insitu_commit_report* report);

/** What validation found, by kind. Errors refuse a mesh; warnings are counted. */
typedef struct insitu_validation {
  size_t size;
  int64_t cells;
  int64_t index_errors;      /**< ids out of range */
  int64_t shape_errors;      /**< unknown shapes, wrong id counts, offsets out of order */
  int64_t coordinate_errors; /**< vertices, used by a cell, that are NaN or infinite */
  int64_t inverted_cells;    /**< warning: volume < 0 */
  int64_t zero_volume_cells; /**< warning: volume 0 to rounding */
  int64_t folded_cells;      /**< warning: the map's Jacobian changes sign somewhere in the cell */
  int64_t collapsed_cells;   /**< warning: two vertices of a cell coincide */
  int64_t ghost_cells;
  /* What does not conform; counted if there are no errors. A point there belongs to the lowest of
   * the cells that hold it, all the same, and a gap between cells is outside. */
  int64_t coincident_vertices; /**< vertices at the place of another, bit for bit: seams. Faces
                                    are matched by place, so these alone lose and double no point */
  int64_t crowded_faces;       /**< faces of three cells or more: cells overlap */
  int64_t split_faces;      /**< quads against two triangles, or against the same corners in another
                                 order: both cells, or none, hold the sliver between */
  int64_t hanging_vertices; /**< vertices on a face or edge of a cell that has no corner there, to
                                 1e-9 of the cell */
  int64_t covered_vertices; /**< vertices in the interior of a cell: cells overlap */
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

/** Validates the arrays as they are now, and faces against each other, which a commit does not.
 *  INSITU_ERROR_MESH, with the first findings in the message, if the mesh would be refused; the
 *  counts are filled in either case. */
INSITU_API insitu_status insitu_mesh_validate(insitu_mesh mesh, insitu_validation* validation);

/** One line of the copy audit. They come as a list, so its size stays as it is. */
typedef struct insitu_audit_entry {
  size_t size;
  char name[64];    /**< "piece 0 points x", "piece 0 field 'velocity' component 1", ... */
  const void* data; /**< the pointer that the kernels read */
  int64_t bytes;    /**< bytes of the array's items */
  int32_t borrowed; /**< 1: the caller's memory in place; 0: converted */
  char reason[64];  /**< why it was converted */
  int32_t reserved[9];
} insitu_audit_entry;

/** The copy audit. *count: in, the room in entries; out, the number of arrays (entries may be null
 *  to ask). */
INSITU_API insitu_status insitu_mesh_audit(insitu_mesh mesh, insitu_audit_entry* entries,
                                           int32_t* count);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_COMMIT_H */
