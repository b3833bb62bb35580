/** @file insitu.h
 *  libinsitu: in-situ queries, tracers and frames for a running simulation. The C99 API and the
 *  one stable ABI; insitu.hpp (C++17) and the Fortran module are thin layers over it.
 *
 *  Rules that hold for every call
 *  - It returns a status; INSITU_OK is 0. On failure insitu_last_message() names the argument and
 *    the numbers. No call aborts, throws, or prints to stdout. A failed call changes nothing.
 *  - Handles are checked: a handle used after its release is answered by INSITU_ERROR_HANDLE.
 *  - A session is used by one thread at a time; a second one inside it gets INSITU_ERROR_BUSY.
 *    Different sessions are independent.
 *  - The caller's floating-point environment (rounding, traps, flush-to-zero) is saved at entry
 *    and restored before return; inside and in the workers the default environment is used.
 *  - Argument structs start with their size; make them with their _default() function, which lets
 *    later versions add members.
 *  - Strings are UTF-8 and copied. Arrays are **external**: the library keeps the pointer and reads
 *    it in place (see insitu_array for how long).
 *  - Ids are 0-based unless an index_base or cell_base argument says otherwise. Coordinates are in
 *    the units of the solver; degrees and metres in geographic frames. */
#ifndef INSITU_H
#define INSITU_H

#include <stddef.h>
#include <stdint.h>

#define INSITU_VERSION_MAJOR 0
#define INSITU_VERSION_MINOR 1
#define INSITU_VERSION_PATCH 0

#if defined(INSITU_STATIC)
#define INSITU_API
#elif defined(_WIN32)
#define INSITU_API __declspec(dllimport)
#else
#define INSITU_API __attribute__((visibility("default")))
#endif

/* Enumerations are ints. In C++ that has to be said, or a value that is none of theirs, which the
 * library tells the caller about, would be undefined behaviour before it could. */
#ifdef __cplusplus
#define INSITU_INT : int
extern "C" {
#else
#define INSITU_INT
#endif

/* ---------------------------------------------------------------------------------------------
 * Status, enumerations. Values are fixed; gaps are for later members.
 * ------------------------------------------------------------------------------------------- */

typedef enum insitu_status INSITU_INT {
  INSITU_OK = 0,
  INSITU_ERROR_ARGUMENT = 1,    /**< an argument is null, negative, of a wrong type or count */
  INSITU_ERROR_HANDLE = 2,      /**< a handle is null, released, or of another kind */
  INSITU_ERROR_BUSY = 3,        /**< another thread is inside this session */
  INSITU_ERROR_ORDER = 4,       /**< calls out of order, such as locate before commit */
  INSITU_ERROR_MESH = 5,        /**< validation refused the mesh */
  INSITU_ERROR_FIELD = 6,       /**< no such field, or its shape does not fit */
  INSITU_ERROR_SCENE = 7,       /**< the scene cannot be parsed or asks for what is not there */
  INSITU_ERROR_FILE = 8,        /**< a file or folder cannot be read or written */
  INSITU_ERROR_MEMORY = 9,      /**< out of memory */
  INSITU_ERROR_UNSUPPORTED = 10, /**< known, but not available in this build or version */
  INSITU_ERROR_CONVERSION = 11, /**< strict mode refuses to copy or convert an array */
  INSITU_ERROR_ACTION = 12,     /**< a probe, tracer or frame failed and was skipped; the rest was done */
  INSITU_ERROR_INTERNAL = 100
} insitu_status;

typedef enum insitu_type INSITU_INT {
  INSITU_FLOAT32 = 1,
  INSITU_FLOAT64 = 2,
  INSITU_INT32 = 3,
  INSITU_INT64 = 4,
  INSITU_UINT8 = 5
} insitu_type;

typedef enum insitu_memory INSITU_INT { INSITU_HOST = 0, INSITU_DEVICE = 1 } insitu_memory;

typedef enum insitu_association INSITU_INT { INSITU_VERTEX = 0, INSITU_CELL = 1 } insitu_association;

/** Cell shapes: VTK's numbers and point order. */
typedef enum insitu_shape INSITU_INT {
  INSITU_TETRAHEDRON = 10,
  INSITU_VOXEL = 11,
  INSITU_HEXAHEDRON = 12,
  INSITU_WEDGE = 13,
  INSITU_PYRAMID = 14
} insitu_shape;

/** What an answer is worth (and costs). In this version all three answer exactly, by a certificate in
 *  floating point or else by exact arithmetic; the reasons tell which. */
typedef enum insitu_accuracy INSITU_INT {
  INSITU_FAST = 0,     /**< reserved for planar faces in float */
  INSITU_STANDARD = 1, /**< bilinear faces */
  INSITU_EXACT = 2     /**< the rule of one owner, whatever it costs */
} insitu_accuracy;

/** What changed since the last commit; combine with |. */
enum {
  INSITU_CHANGED_NOTHING = 0,
  INSITU_CHANGED_FIELDS = 1,   /**< field values */
  INSITU_CHANGED_GEOMETRY = 2, /**< vertex coordinates */
  INSITU_CHANGED_TOPOLOGY = 4, /**< cells, pieces, ghost bits (implies geometry and fields) */
  INSITU_CHANGED_ALL = 7
};

typedef enum insitu_log_level INSITU_INT {
  INSITU_LOG_ERROR = 1,
  INSITU_LOG_WARNING = 2,
  INSITU_LOG_INFO = 3,
  INSITU_LOG_DEBUG = 4
} insitu_log_level;

/** Opaque handles: a session, and a mesh that belongs to one session. */
typedef struct insitu_session_handle* insitu_session;
typedef struct insitu_mesh_handle* insitu_mesh;

/** The name of a status, such as "INSITU_ERROR_MESH". Never null. */
INSITU_API const char* insitu_status_name(insitu_status status);

/** The version of the library that is running; each pointer may be null. */
INSITU_API insitu_status insitu_version(int* major, int* minor, int* patch);

/** The message of the calling thread's last failed call ("" if none). Valid until the thread's
 *  next call of this library. Never null. */
INSITU_API const char* insitu_last_message(void);

/* ---------------------------------------------------------------------------------------------
 * Sessions
 * ------------------------------------------------------------------------------------------- */

/** Receives the library's messages, on the thread that called the library. Must not call back. */
typedef void (*insitu_log_function)(insitu_log_level level, const char* message, void* user);

typedef struct insitu_session_options {
  size_t size;
  const char* scene;       /**< path of a scene file; null: none */
  const char* scene_text;  /**< the scene itself, as text; at most one of both. With neither, the
                                default scene if default_scene is not 0, else nothing is executed */
  const char* output;      /**< output folder, overrides the scene's; null: the scene's */
  int32_t default_scene;   /**< 1: with no scene, draw the first scalar field every tenth cycle */
  int32_t threads;         /**< at most so many threads; 0: all that the process's affinity allows */
  int32_t strict;          /**< 1: refuse arrays that would have to be copied or converted */
  insitu_log_level log_level; /**< messages up to this level reach the log */
  insitu_log_function log; /**< null: errors and warnings go to stderr */
  void* log_user;
  const void* communicator;     /**< address of an MPI_Comm, kept; serial in this version */
  int32_t fortran_communicator; /**< the same as a Fortran integer; used if communicator is null */
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
  o.fortran_communicator = 0;
  return o;
}

/** Opens a session. options may be null (the defaults). A bad scene is an error here, with file,
 *  line, key and the nearest valid key in the message; *session is then null. */
INSITU_API insitu_status insitu_session_open(const insitu_session_options* options,
                                             insitu_session* session);

/** Ends tracers, closes files, releases the session and its meshes, and sets *session to null.
 *  A null *session is fine. */
INSITU_API insitu_status insitu_session_close(insitu_session* session);

/** The mesh of that name, made empty on first use. */
INSITU_API insitu_status insitu_session_mesh(insitu_session session, const char* name,
                                             insitu_mesh* mesh);

/** Commits every mesh, then does what the scene asks for at this cycle: probes, tracers, frames.
 *  cycle: the solver's step number; time: its physical time (not decreasing while tracers live).
 *  An action that fails is logged and skipped; the others are done; the status is then
 *  INSITU_ERROR_ACTION and the message tells which. */
INSITU_API insitu_status insitu_session_execute(insitu_session session, int64_t cycle, double time);

/* ---------------------------------------------------------------------------------------------
 * Meshes
 *
 * A mesh is a list of pieces, numbered from 0 without gaps; most meshes have piece 0 alone. A
 * piece is a set of cells over vertices, or an implicit block of hexahedra. Calling again replaces
 * what was given before. Nothing is read before the commit.
 * ------------------------------------------------------------------------------------------- */

/** A view of the caller's memory; not owned, not copied.
 *  Item (i, j, k), component c lies at data + i*stride[0] + j*stride[1] + k*stride[2] +
 *  c*component_stride bytes. A one-dimensional array sets count and leaves extent 0; otherwise
 *  count is the product of the extents and item ids run i fastest. Strides may be negative.
 *  Validity: read between the commit and the return of the last call that uses the mesh in this
 *  step, hence also by insitu_session_execute. Memory may be freed or moved once the mesh is
 *  released or the array replaced. Nothing is read past the last item. */
typedef struct insitu_array {
  size_t size;
  const void* data;
  insitu_type type;
  int32_t components;
  int64_t count;
  int64_t extent[3];
  int64_t stride[3];        /**< bytes; 0: packed */
  int64_t component_stride; /**< bytes; 0: the components of an item are adjacent */
  insitu_memory memory;
  const char* converted;    /**< null, or why an adaptor had to make this copy (for the audit) */
} insitu_array;

static inline insitu_array insitu_array_default(void) {
  insitu_array a;
  int i;
  a.size = sizeof a;
  a.data = NULL;
  a.type = INSITU_FLOAT64;
  a.components = 1;
  a.count = 0;
  for (i = 0; i < 3; ++i)
    a.extent[i] = a.stride[i] = 0;
  a.component_stride = 0;
  a.memory = INSITU_HOST;
  a.converted = NULL;
  return a;
}

/** A packed array of count items of components values each. */
static inline insitu_array insitu_array_of(const void* data, insitu_type type, int64_t count,
                                           int32_t components) {
  insitu_array a = insitu_array_default();
  a.data = data;
  a.type = type;
  a.count = count;
  a.components = components;
  return a;
}

typedef enum insitu_layout INSITU_INT {
  INSITU_LAYOUT_UNIFORM = 0, /**< one shape for all cells; connectivity [count][vertices of shape] */
  INSITU_LAYOUT_MIXED = 1,   /**< types[count], offsets[count] or [count + 1], connectivity[...] */
  INSITU_LAYOUT_PADDED = 2   /**< connectivity [count][8], unused ids -1; the shape follows from the
                                  number of ids: 4, 5, 6, 8 */
} insitu_layout;

/** The cells of a piece. connectivity is int32 or int64; for UNIFORM and PADDED an item is a cell
 *  with as many components as it has ids, for MIXED an item is one id. */
typedef struct insitu_cells {
  size_t size;
  insitu_layout layout;
  insitu_shape shape; /**< for UNIFORM; one of VOXEL, HEXAHEDRON for 8 ids in PADDED */
  int64_t count;
  insitu_array connectivity;
  insitu_array types;   /**< for MIXED: uint8, VTK's numbers */
  insitu_array offsets; /**< for MIXED: int32 or int64, where a cell's ids start */
  int32_t index_base;   /**< 0 or 1: how the ids in connectivity (and in offsets) count */
} insitu_cells;

static inline insitu_cells insitu_cells_default(void) {
  insitu_cells c;
  c.size = sizeof c;
  c.layout = INSITU_LAYOUT_UNIFORM;
  c.shape = INSITU_HEXAHEDRON;
  c.count = 0;
  c.connectivity = insitu_array_default();
  c.types = insitu_array_default();
  c.offsets = insitu_array_default();
  c.index_base = 0;
  return c;
}

typedef enum insitu_block_kind INSITU_INT {
  INSITU_BLOCK_UNIFORM = 0,     /**< origin and spacing */
  INSITU_BLOCK_RECTILINEAR = 1, /**< one coordinate array an axis */
  INSITU_BLOCK_CURVILINEAR = 2  /**< points given by insitu_mesh_points */
} insitu_block_kind;

/** An implicit block: vertices (i, j, k), id i + ni*(j + nj*k); the cell (i, j, k) is the
 *  hexahedron from vertex (i, j, k) to (i+1, j+1, k+1), id i + (ni-1)*(j + (nj-1)*k). Sub-blocks of
 *  larger arrays, ghost layers and C order are said by the extents and strides of the arrays. */
typedef struct insitu_block {
  size_t size;
  insitu_block_kind kind;
  int64_t vertices[3];         /**< vertices along i, j, k; at least 2 each */
  double origin[3];            /**< UNIFORM */
  double spacing[3];           /**< UNIFORM; not 0 */
  insitu_array coordinates[3]; /**< RECTILINEAR: vertices[a] values along axis a */
} insitu_block;

static inline insitu_block insitu_block_default(void) {
  insitu_block b;
  int i;
  b.size = sizeof b;
  b.kind = INSITU_BLOCK_CURVILINEAR;
  for (i = 0; i < 3; ++i) {
    b.vertices[i] = 0;
    b.origin[i] = 0.0;
    b.spacing[i] = 1.0;
    b.coordinates[i] = insitu_array_default();
  }
  return b;
}

/** The vertices of a piece: one interleaved array of 3 components, or three arrays x, y, z of one
 *  component (array_count 1 or 3), float32 or float64. */
INSITU_API insitu_status insitu_mesh_points(insitu_mesh mesh, int32_t piece,
                                            const insitu_array* arrays, int32_t array_count);

/** The cells of a piece, by connectivity. Ghosts given before stay; give new ones, or
 *  none, if they do not fit the new cells. */
INSITU_API insitu_status insitu_mesh_cells(insitu_mesh mesh, int32_t piece,
                                           const insitu_cells* cells);

/** The cells of a piece, as an implicit block. Ghosts given before stay. */
INSITU_API insitu_status insitu_mesh_block(insitu_mesh mesh, int32_t piece,
                                           const insitu_block* block);

/** A field on vertices or cells: one array of any component count, or one array a component;
 *  float32 or float64. All pieces must have it, with equal association and components. */
INSITU_API insitu_status insitu_mesh_field(insitu_mesh mesh, int32_t piece, const char* name,
                                           insitu_association association,
                                           const insitu_array* arrays, int32_t array_count);

INSITU_API insitu_status insitu_mesh_remove_field(insitu_mesh mesh, const char* name);

/** How a ghost array counts. */
typedef enum insitu_ghost_convention INSITU_INT {
  INSITU_GHOSTS_VTK = 0,   /**< bits: 1 duplicate, 8 refined, 32 hidden: the cell owns no point */
  INSITU_GHOSTS_ASCENT = 1 /**< 0 real, otherwise ghost */
} insitu_ghost_convention;

/** One uint8 a cell. A ghost cell never owns a point and is never drawn. array null: none. They stay
 *  when the cells are given again. */
INSITU_API insitu_status insitu_mesh_ghosts(insitu_mesh mesh, int32_t piece,
                                            const insitu_array* array,
                                            insitu_ghost_convention convention);

typedef enum insitu_frame_kind INSITU_INT {
  INSITU_FRAME_CARTESIAN = 0,  /**< the solver's own coordinates */
  INSITU_FRAME_GEOCENTRIC = 1, /**< ECEF metres on WGS84 */
  INSITU_FRAME_GEODETIC = 2,   /**< longitude, latitude in degrees, height in metres */
  INSITU_FRAME_ENU = 3,        /**< metres east, north, up of an origin (lon, lat, height) */
  INSITU_FRAME_UTM = 4         /**< easting, northing, height in metres in a zone */
} insitu_frame_kind;

typedef struct insitu_frame {
  size_t size;
  insitu_frame_kind kind;
  double origin[3];  /**< ENU: longitude, latitude (degrees), height (metres) */
  int32_t utm_zone;  /**< UTM: 1..60 */
  int32_t utm_north; /**< UTM: 1 north, 0 south */
} insitu_frame;

static inline insitu_frame insitu_frame_default(void) {
  insitu_frame f;
  f.size = sizeof f;
  f.kind = INSITU_FRAME_CARTESIAN;
  f.origin[0] = f.origin[1] = f.origin[2] = 0.0;
  f.utm_zone = 0;
  f.utm_north = 1;
  return f;
}

/** The frame of the mesh's coordinates; points given in another frame are converted to it. Cells
 *  are located as they are: a geodetic mesh is not supported in this version. */
INSITU_API insitu_status insitu_mesh_frame(insitu_mesh mesh, const insitu_frame* frame);

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
  double cost_ratio;       /**< cost of the refitted tree over that of the last build (1 if built) */
  insitu_builder builder;  /**< of the tree that answers after the commit */
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
  return r;
}

/** Brings the structures up to date: topology -> rebuild; geometry -> refit, or rebuild once the
 *  refitted tree costs too much; fields -> value ranges; nothing -> nothing. Once enough points were
 *  located to pay for it, a geometry or fields commit also rebuilds by surface area. The
 *  first commit validates the mesh, and so does one after a change of topology. report may be null. */
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
  /* What does not conform; counted if there are no errors. A point there belongs to the lowest of the
   * cells that hold it, all the same, and a gap between cells is outside. */
  int64_t coincident_vertices; /**< vertices at the place of another, bit for bit: seams. Faces are
                                *   matched by place, so these alone lose and double no point. */
  int64_t crowded_faces;       /**< faces of three cells or more: cells overlap */
  int64_t split_faces; /**< quads against two triangles or against the same corners in another order:
                        *   the sliver between belongs to both cells or to none */
} insitu_validation;

static inline insitu_validation insitu_validation_default(void) {
  insitu_validation v;
  v.size = sizeof v;
  v.cells = v.index_errors = v.shape_errors = v.coordinate_errors = v.inverted_cells = 0;
  v.zero_volume_cells = v.folded_cells = v.collapsed_cells = v.ghost_cells = 0;
  v.coincident_vertices = v.crowded_faces = v.split_faces = 0;
  return v;
}

/** Validates the arrays as they are now, and faces against each other, which a commit does not. INSITU_ERROR_MESH, with the first findings in the message, if the
 *  mesh would be refused; the counts are filled in either case. */
INSITU_API insitu_status insitu_mesh_validate(insitu_mesh mesh, insitu_validation* validation);

/** One line of the copy audit. */
typedef struct insitu_audit_entry {
  size_t size;
  char name[64];    /**< "piece 0 points x", "piece 0 field 'velocity' component 1", ... */
  const void* data; /**< the pointer that the kernels read */
  int64_t bytes;    /**< bytes of the array's items */
  int32_t borrowed; /**< 1: the caller's memory in place; 0: converted */
  char reason[64];  /**< why it was converted */
} insitu_audit_entry;

/** The copy audit. *count: in, the room in entries; out, the number of arrays (entries may be null to
 *  ask). */
INSITU_API insitu_status insitu_mesh_audit(insitu_mesh mesh, insitu_audit_entry* entries,
                                           int32_t* count);

/* ---------------------------------------------------------------------------------------------
 * Queries. Any number of times after a commit, until the solver changes the arrays. The checked build
 * (or INSITU_CHECKED=1 in the environment when the session is opened) answers a query, or a commit that
 * was not told, by INSITU_ERROR_ORDER if coordinates, cells or ghosts are not what was committed.
 * ------------------------------------------------------------------------------------------- */

/** Why a point has the owner that it has. */
typedef enum insitu_reason INSITU_INT {
  INSITU_REASON_OUTSIDE = 0,   /**< no cell that may own points holds it */
  INSITU_REASON_CERTIFIED = 1, /**< strictly inside its owner, proven in floating point */
  INSITU_REASON_EXACT = 2,     /**< strictly inside its owner, by exact arithmetic */
  INSITU_REASON_ON_FACE = 3,   /**< on a face of its owner, which has the lowest id of the cells there */
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
} insitu_locate_args;

static inline insitu_locate_args insitu_locate_args_default(void) {
  insitu_locate_args a;
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
  return a;
}

/** Which cell owns each point. Of the closed cells that hold a point, the lowest (piece, cell)
 *  owns it; ghost cells own nothing. NaN and infinite points are outside. */
INSITU_API insitu_status insitu_mesh_locate(insitu_mesh mesh, const insitu_locate_args* args);

typedef struct insitu_sample_args {
  size_t size;
  insitu_locate_args locate; /**< the points and, if wanted, where they lie */
  const char* const* fields; /**< [field_count] names */
  int32_t field_count;
  double* const* values;     /**< [field_count] outputs, each [count][components of the field] */
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

/* ---------------------------------------------------------------------------------------------
 * Reports
 * ------------------------------------------------------------------------------------------- */

/** Why a particle ended. */
typedef enum insitu_ending INSITU_INT {
  INSITU_END_ALIVE = 0,
  INSITU_END_LEFT = 1,       /**< left the mesh */
  INSITU_END_STAGNATED = 2,  /**< came to rest in a steady field, or no step could be found */
  INSITU_END_EXPIRED = 3,    /**< reached its time, length or age */
  INSITU_END_STEP_LIMIT = 4, /**< took the largest number of steps */
  INSITU_END_SEED_OUTSIDE = 5, /**< was seeded outside the mesh */
  INSITU_END_NOT_FINITE = 6, /**< the velocity is NaN or infinite */
  INSITU_END_KILLED = 7,     /**< the session was closed while it lived */
  INSITU_END_COUNT = 8
} insitu_ending;

/** What the memory is for. */
typedef enum insitu_purpose INSITU_INT {
  INSITU_MEMORY_TREE = 0,      /**< nodes and leaves */
  INSITU_MEMORY_BUILD = 1,     /**< kept scratch of the builder */
  INSITU_MEMORY_RANGES = 2,    /**< value ranges */
  INSITU_MEMORY_EARLIER = 3,   /**< the earlier step, kept for pathlines */
  INSITU_MEMORY_QUERY = 4,     /**< scratch of queries */
  INSITU_MEMORY_TRACER = 5,    /**< particles */
  INSITU_MEMORY_FRAME = 6,     /**< images */
  INSITU_MEMORY_CONVERTED = 7, /**< arrays that adaptors had to convert */
  INSITU_MEMORY_EMBREE = 8,    /**< what Embree holds */
  INSITU_MEMORY_COUNT = 9
} insitu_purpose;

/** Totals since the session was opened. Seconds are wall-clock seconds in the library. */
typedef struct insitu_report {
  size_t size;
  int64_t executions;
  double commit_s, query_s, advect_s, render_s, output_s;
  int64_t keeps, refits, rebuilds;
  int64_t bytes_borrowed; /**< of the solver's arrays that are read in place */
  int64_t bytes_held;     /**< of the library's own memory, now */
  int64_t bytes_peak;
  int64_t bytes_by_purpose[INSITU_MEMORY_COUNT]; /**< now */
  int64_t points_located, points_outside;
  int64_t particles_seeded;
  int64_t particles[INSITU_END_COUNT]; /**< sums up to particles_seeded */
  int64_t frames, probe_rows, files;
  int64_t failures; /**< actions that were skipped */
  int64_t located_by_reason[INSITU_REASON_COUNT]; /**< every point located for whatever purpose:
                                 queries, probes, tracers and samples of frames, of all meshes */
} insitu_report;

static inline insitu_report insitu_report_default(void) {
  insitu_report r;
  int i;
  r.size = sizeof r;
  r.executions = 0;
  r.commit_s = r.query_s = r.advect_s = r.render_s = r.output_s = 0.0;
  r.keeps = r.refits = r.rebuilds = 0;
  r.bytes_borrowed = r.bytes_held = r.bytes_peak = 0;
  for (i = 0; i < INSITU_MEMORY_COUNT; ++i)
    r.bytes_by_purpose[i] = 0;
  r.points_located = r.points_outside = 0;
  r.particles_seeded = 0;
  for (i = 0; i < INSITU_END_COUNT; ++i)
    r.particles[i] = 0;
  r.frames = r.probe_rows = r.files = r.failures = 0;
  for (i = 0; i < INSITU_REASON_COUNT; ++i)
    r.located_by_reason[i] = 0;
  return r;
}

INSITU_API insitu_status insitu_session_report(insitu_session session, insitu_report* report);

/** Writes the report as JSON; solver_s: the solver's own seconds, for the library's share of the
 *  run (negative: leave it out). */
INSITU_API insitu_status insitu_session_write_summary(insitu_session session, const char* path,
                                                      double solver_s);

#undef INSITU_INT
#ifdef __cplusplus
}
#endif

#endif /* INSITU_H */
