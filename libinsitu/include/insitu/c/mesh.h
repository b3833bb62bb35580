/** @file mesh.h
 *  The caller describes a mesh by points, cells or blocks, fields, ghosts and a frame.
 *
 *  A mesh is a list of pieces, numbered from 0 without gaps; most meshes have piece 0 alone. A
 *  piece is a set of cells over vertices, polyhedra given by their faces among them, or an implicit
 *  block of hexahedra; the pieces of an adaptive mesh are patches or leaves instead
 *  (insitu/c/amr.h). A later call replaces what an earlier one gave. The library reads no array
 *  before the commit. */
#ifndef INSITU_C_MESH_H
#define INSITU_C_MESH_H

#include "insitu/c/array.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum insitu_association INSITU_INT {
  INSITU_VERTEX = 0,
  INSITU_CELL = 1
} insitu_association;

/** Cell shapes, with VTK's numbers and VTK's order of points. Triangles, pixels and quads are cells
 *  of flat meshes (doc/guide/flat.md). */
typedef enum insitu_shape INSITU_INT {
  INSITU_TRIANGLE = 5,
  INSITU_PIXEL = 8,
  INSITU_QUAD = 9,
  INSITU_TETRAHEDRON = 10,
  INSITU_VOXEL = 11,
  INSITU_HEXAHEDRON = 12,
  INSITU_WEDGE = 13,
  INSITU_PYRAMID = 14
} insitu_shape;

typedef enum insitu_layout INSITU_INT {
  INSITU_LAYOUT_UNIFORM = 0, /**< one shape; connectivity [count][vertices of the shape] */
  INSITU_LAYOUT_MIXED = 1,   /**< types[count], offsets[count] or [count + 1], connectivity[...] */
  INSITU_LAYOUT_PADDED = 2   /**< connectivity [count][8], in which unused ids are -1; the shape
                                  follows from the number of ids: 4, 5, 6, 8; of a flat mesh
                                  [count][4], with 3 or 4 ids */
} insitu_layout;

/** The cells of a piece. connectivity is int32 or int64. For UNIFORM and PADDED one item of it is a
 *  cell, with as many components as the cell has ids; for MIXED one item is one id. */
typedef struct insitu_cells {
  size_t size;
  insitu_layout layout;
  insitu_shape shape; /**< for UNIFORM: the shape; for PADDED: VOXEL or HEXAHEDRON, the shape of 8
                           ids, or PIXEL or QUAD, the shape of 4 ids of a flat mesh */
  int64_t count;
  insitu_array connectivity;
  insitu_array types;   /**< for MIXED: uint8, VTK's numbers */
  insitu_array offsets; /**< for MIXED: int32 or int64, the places in connectivity where the ids of
                             cells start */
  int32_t index_base;   /**< 0 or 1: the number from which the ids in connectivity (and offsets)
                             count */
  int32_t reserved;     /**< always 0 */
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
  c.reserved = 0;
  return c;
}

typedef enum insitu_faces_form INSITU_INT {
  INSITU_FACES_OWNERS = 0, /**< each face names its one or two cells */
  INSITU_FACES_CELLS = 1   /**< each cell names its faces */
} insitu_faces_form;

/** The cells of a piece by their faces: polyhedra of any number of faces, each of any number of
 *  vertices. A face is a ring of vertex ids, wound either way, since no orientation is read. Each
 *  face bounds one cell or two, and each edge of a cell lies on two faces of it. All arrays of ids
 *  are int32 or int64, evenly spaced, and count from index_base. How such cells are located is told
 *  in doc/guide/polyhedra.md.
 *
 *  Rings may also lie in records of their own, as in OpenFOAM's lists of faces. Then vertices is
 *  indirect (insitu_array): pointer i leads to the packed ids of face i, and offsets holds the
 *  number of ids of each face. A commit of INSITU_CHANGED_TOPOLOGY refuses a null pointer.
 *
 *  OWNERS: owner names one cell a face, and neighbour the other cell of the first
 *  neighbour.count faces, or an id below index_base where a face has no other. owner may have two
 *  components instead, which are both cells of a face. Faces of one cell may lie in arrays of their
 *  own: the boundary arrays hold boundary_count faces, whose numbers follow those of the others.
 *
 *  CELLS: cell_faces lists the faces, cell after cell; a face that two cells share is listed
 *  twice. */
typedef struct insitu_faces {
  size_t size;
  insitu_faces_form form;
  int32_t index_base; /**< 0 or 1: the number from which ids and offsets count */
  int64_t cell_count;
  int64_t face_count;    /**< of the arrays vertices and offsets */
  insitu_array vertices; /**< the ids of the faces' vertices, face after face; if indirect,
                              [face_count] */
  insitu_array offsets;  /**< [face_count + 1]: the places in vertices where the ids of faces start,
                              and the end of the last face's, or without that, which is the end of
                              vertices; where vertices is indirect: how many ids each face has */
  insitu_array owner;    /**< for OWNERS: [face_count], one or two components */
  insitu_array neighbour;         /**< for OWNERS: at most [face_count]; no items if owner has two
                                       components */
  int64_t boundary_count;         /**< for OWNERS: the number of faces in the next three arrays */
  insitu_array boundary_vertices; /**< as vertices */
  insitu_array boundary_offsets;  /**< [boundary_count + 1], as offsets */
  insitu_array boundary_owner;    /**< [boundary_count] */
  int64_t far_cells;              /**< for OWNERS: so many ids from the last cell's on stand for
                                       cells that the piece does not have, such as those of other
                                       processes, and are no cells here */
  insitu_array cell_faces;        /**< for CELLS: ids of faces, cell after cell */
  insitu_array cell_offsets;      /**< for CELLS: [cell_count + 1]: the places in cell_faces where
                                       faces of cells start, and the last one's end, or without */
} insitu_faces;

static inline insitu_faces insitu_faces_default(void) {
  insitu_faces f;
  f.size = sizeof f;
  f.form = INSITU_FACES_OWNERS;
  f.index_base = 0;
  f.cell_count = f.face_count = 0;
  f.vertices = f.offsets = f.owner = f.neighbour = insitu_array_default();
  f.boundary_count = 0;
  f.boundary_vertices = f.boundary_offsets = f.boundary_owner = insitu_array_default();
  f.far_cells = 0;
  f.cell_faces = f.cell_offsets = insitu_array_default();
  return f;
}

typedef enum insitu_block_kind INSITU_INT {
  INSITU_BLOCK_UNIFORM = 0,     /**< vertices follow from origin and spacing */
  INSITU_BLOCK_RECTILINEAR = 1, /**< vertices follow from one coordinate array an axis */
  INSITU_BLOCK_CURVILINEAR = 2  /**< insitu_mesh_points gives the vertices */
} insitu_block_kind;

/** An implicit block has vertices (i, j, k) with ids i + ni*(j + nj*k). Its cell (i, j, k) is the
 *  hexahedron from vertex (i, j, k) to (i+1, j+1, k+1), with the id i + (ni-1)*(j + (nj-1)*k). The
 *  extents and strides of the arrays describe sub-blocks of larger arrays, ghost layers and C
 *  order. */
typedef struct insitu_block {
  size_t size;
  insitu_block_kind kind;
  int64_t vertices[3];         /**< number of vertices along i, j, k; below 2 along an axis: the
                                    block has no cells, but see dimensions */
  double origin[3];            /**< for UNIFORM */
  double spacing[3];           /**< for UNIFORM; not 0 */
  insitu_array coordinates[3]; /**< for RECTILINEAR: vertices[a] values along axis a */
  int64_t first[3];            /**< for UNIFORM: vertex (i, j, k) lies at
                                    origin[a] + (first[a] + i) * spacing[a], so that the blocks of a
                                    grid that share its origin meet to the bit; 0 else */
  int32_t dimensions;          /**< 3, or 2: a flat block of quads, which has one vertex along k and
                                    reads nothing else of k */
  int32_t reserved;            /**< always 0 */
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
    b.first[i] = 0;
  }
  b.dimensions = 3;
  b.reserved = 0;
  return b;
}

/** Gives the vertices of a piece: one interleaved array of 3 components, or three arrays x, y, z of
 *  one component (array_count 1 or 3), float32 or float64. The vertices of a flat mesh may lack z:
 *  one array of 2 components, or two arrays (array_count 2). */
INSITU_API insitu_status insitu_mesh_points(insitu_mesh mesh, int32_t piece,
                                            const insitu_array* arrays, int32_t array_count);

/** Gives the cells of a piece by connectivity. Ghosts given before stay; where they do not fit the
 *  new cells, the caller gives others, or none. */
INSITU_API insitu_status insitu_mesh_cells(insitu_mesh mesh, int32_t piece,
                                           const insitu_cells* cells);

/** Gives the cells of a piece by their faces. Ghosts given before stay. The commit recognises
 *  tetrahedra, pyramids, wedges and hexahedra, and cuts any other cell around a point of it
 *  (INSITU_MEMORY_POLYHEDRA). It refuses faces that do not bound cells (INSITU_ERROR_MESH), and
 * names the piece, the cell and the face. Such meshes lie in host memory, and are not in longitude
 * and latitude. */
INSITU_API insitu_status insitu_mesh_faces(insitu_mesh mesh, int32_t piece,
                                           const insitu_faces* faces);

/** Gives the cells of a piece as an implicit block. Ghosts given before stay. */
INSITU_API insitu_status insitu_mesh_block(insitu_mesh mesh, int32_t piece,
                                           const insitu_block* block);

/** Gives a field on vertices or cells: one array of any number of components, or one array a
 *  component; float32 or float64. All pieces that have cells must have the field, with equal
 *  association and components. A piece without cells adds nothing, whether or not it has points and
 *  fields. */
INSITU_API insitu_status insitu_mesh_field(insitu_mesh mesh, int32_t piece, const char* name,
                                           insitu_association association,
                                           const insitu_array* arrays, int32_t array_count);

INSITU_API insitu_status insitu_mesh_remove_field(insitu_mesh mesh, const char* name);

/** Says that items of a field that hold `value`, as the field's type has it, have no value: land,
 *  say, or netCDF's _FillValue. NaN may be such a value. A vertex or cell is blank if one of its
 *  components is. Calls add up; removing the field forgets them. Cells with blank vertices still
 *  own points, and all other fields have values there, but samples of this field are NaN,
 *  isosurfaces and volumes leave these cells out, averages leave blank cells out, and tracers along
 *  this field take these cells as a wall: without effects at the boundary particles end as
 *  INSITU_END_BLANK. Every commit copies the field's values (INSITU_MEMORY_BLANK), unless the field
 *  has one component and NaN alone is blank; strict sessions refuse the copy. Fields in device
 *  memory (INSITU_ERROR_UNSUPPORTED) and on adaptive meshes (INSITU_ERROR_ORDER) have no blank
 *  values. */
INSITU_API insitu_status insitu_mesh_field_blank(insitu_mesh mesh, const char* name, double value);

/** Gives VTK's vtkGhostType of points, one uint8 a vertex of a piece: where bit 2 (hidden) is set,
 *  no field on vertices has a value, as if all of them were blank there. The library ignores other
 *  bits. array null takes the hidden points away. */
INSITU_API insitu_status insitu_mesh_hidden_points(insitu_mesh mesh, int32_t piece,
                                                   const insitu_array* array);

/** Drops the pieces from `first` on, with everything that was given for them, since a regrid may
 *  leave fewer patches. first: 0 to the number of pieces. */
INSITU_API insitu_status insitu_mesh_drop_pieces(insitu_mesh mesh, int32_t first);

/** Says whether the mesh's pieces are parts of one body (separate 0, as at first) or stand for
 *  themselves (separate not 0). In one body, vertices of different pieces whose coordinates are
 *  equal bit for bit are one vertex where isosurfaces of cell fields average values and smooth
 *  normals average gradients. Within a piece ids alone tell vertices apart, so cracks and baffles
 *  stay. The call takes effect at the next commit of the geometry, which it asks for. */
INSITU_API insitu_status insitu_mesh_separate_pieces(insitu_mesh mesh, int separate);

/** How the library reads a ghost array. */
typedef enum insitu_ghost_convention INSITU_INT {
  INSITU_GHOSTS_VTK = 0,   /**< bits; 1 (duplicate), 8 (refined) or 32 (hidden): the cell owns no
                                point */
  INSITU_GHOSTS_ASCENT = 1 /**< 0: a real cell; any other number: a ghost cell */
} insitu_ghost_convention;

/** Gives the ghosts of a piece, one uint8 a cell. A ghost cell never owns a point, is never drawn,
 *  and may hold anything. But a cell that is only a duplicate (VTK: 1 with neither 8 nor 32;
 *  Ascent: 1) lends its values, where its vertex ids are in range and the values are finite, to
 *  smooth normals and to averages of cell fields at the vertices that it shares with owning cells:
 *  so surfaces meet without a seam where another process goes on. array null takes the ghosts away.
 *  Ghosts stay when the caller gives the cells again. */
INSITU_API insitu_status insitu_mesh_ghosts(insitu_mesh mesh, int32_t piece,
                                            const insitu_array* array,
                                            insitu_ghost_convention convention);

/** Gives the global ids of the cells or vertices of a piece: the numbers that they have in the mesh
 *  of all processes, one int32 or int64 each, 0 or above; the arrays stay the caller's. A vertex
 *  that several pieces or processes have has one global id; a cell that owns points has one of its
 *  own. Where all pieces have global ids of cells, tables and answers name cells by them, and of
 * the cells that hold a point the one with the lowest answers, on whatever process it is: so
 * answers do not depend on how the mesh is cut. For that, the ids of a process's cells ascend from
 * piece to piece and in each; where they do not, a warning tells so, and a point on a face between
 * two of its cells belongs to the first of them. Ids of ghost cells are not read. array null takes
 * the ids away. Ids stay when the caller gives the cells again; where they do not fit these, the
 * caller gives others. Vertices of adaptive meshes (INSITU_ERROR_ORDER) and device memory
 *  (INSITU_ERROR_UNSUPPORTED) have none. */
INSITU_API insitu_status insitu_mesh_global_ids(insitu_mesh mesh, int32_t piece,
                                                insitu_association association,
                                                const insitu_array* array);

typedef enum insitu_frame_kind INSITU_INT {
  INSITU_FRAME_CARTESIAN = 0,  /**< the solver's own coordinates */
  INSITU_FRAME_GEOCENTRIC = 1, /**< ECEF metres on WGS84 */
  INSITU_FRAME_GEODETIC = 2,   /**< longitude, latitude, and height or depth on WGS84, in the units
                                    below */
  INSITU_FRAME_ENU = 3,        /**< metres east, north and up of an origin
                                    (longitude, latitude, height) */
  INSITU_FRAME_UTM = 4         /**< metres of easting, northing and height in a zone */
} insitu_frame_kind;

/** The units of GEODETIC longitudes and latitudes and of the third number, and its direction. */
typedef enum insitu_angle INSITU_INT { INSITU_DEGREES = 0, INSITU_RADIANS = 1 } insitu_angle;
typedef enum insitu_length INSITU_INT { INSITU_METRES = 0, INSITU_KILOMETRES = 1 } insitu_length;
typedef enum insitu_vertical INSITU_INT {
  INSITU_UP = 0,  /**< a height above the ellipsoid */
  INSITU_DOWN = 1 /**< a depth below the ellipsoid; UTM may have it too */
} insitu_vertical;

typedef struct insitu_frame {
  size_t size;
  insitu_frame_kind kind;
  double origin[3];         /**< for ENU: longitude, latitude (degrees), height (metres) */
  int32_t utm_zone;         /**< for UTM: 1 to 60 */
  int32_t utm_north;        /**< for UTM: 1 north, 0 south */
  insitu_angle angle;       /**< for GEODETIC; otherwise DEGREES */
  insitu_length length;     /**< for GEODETIC: unit of the third number; otherwise METRES */
  insitu_vertical vertical; /**< for GEODETIC and UTM; otherwise UP */
  int32_t reserved;         /**< always 0 */
} insitu_frame;

static inline insitu_frame insitu_frame_default(void) {
  insitu_frame f;
  f.size = sizeof f;
  f.kind = INSITU_FRAME_CARTESIAN;
  f.origin[0] = f.origin[1] = f.origin[2] = 0.0;
  f.utm_zone = 0;
  f.utm_north = 1;
  f.angle = INSITU_DEGREES;
  f.length = INSITU_METRES;
  f.vertical = INSITU_UP;
  f.reserved = 0;
  return f;
}

/** Sets the frame of the mesh's coordinates; the library converts points of another frame to it. It
 *  locates points in cells as the arrays give them, straight in these coordinates. For a geodetic
 *  mesh that means:
 *
 *  - Longitudes may start anywhere (-180, 0, 170, ...), and points may have any longitude of the
 *    same meridian: each point is located once. Cells may wrap around (from 359.5 to 0.5), hold a
 *    pole or have a vertex there: the library locates points in copies of these few cells, which
 *    insitu_report counts (memory) and the commit's log tells, and reads all other cells in place.
 *    A cell spans less than half a turn.
 *  - Vector fields (3 components) are along east, north and up; tracers take them as metres per
 *    second. Near a pole that lies within a cell the library turns vectors with the direction east
 *    before it interpolates them; samples are along the east and north of the sampled point.
 *  - The mesh lies in host memory, and points are located on the CPU.
 *
 *  In any other frame vector fields are along the axes of the mesh's coordinates: in a geocentric
 *  mesh along the Earth's x, y and z; in UTM with depths the third component is the rate at which
 *  depth grows. */
INSITU_API insitu_status insitu_mesh_frame(insitu_mesh mesh, const insitu_frame* frame);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_MESH_H */
