/** @file amr.h
 *  Adaptive meshes are made of cell-centred patches of levels, or of leaves of octrees, as the
 *  solver stores them. insitu_mesh_field gives their values with INSITU_CELL; the extents and
 *  strides of the arrays leave ghost layers out and describe C order. Between cell centres the
 *  library interpolates on the dual mesh. A commit of INSITU_CHANGED_TOPOLOGY (a regrid) builds the
 *  dual mesh; other commits keep it. */
#ifndef INSITU_C_AMR_H
#define INSITU_C_AMR_H

#include "insitu/c/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { INSITU_AMR_MOST_LEVELS = 31 };

/** How samples of an adaptive mesh follow from the cells' values. */
typedef enum insitu_reconstruction INSITU_INT {
  INSITU_DUAL = 0,   /**< the dual mesh's interpolant: it is continuous and has each cell's value at
                          the cell's centre. From the outermost centres to the boundary the value is
                          kept, or goes on towards the ghost cells of insitu_patch. It may jump
                          across planes in which the domain ends in the midst of a coarser cell's
                          face */
  INSITU_NEAREST = 1 /**< the value of the cell that holds the point */
} insitu_reconstruction;

/** The lattices of an adaptive mesh's levels. Cell (i, j, k) of a level spans from
 *  origin + (i, j, k) * h to origin + (i + 1, j + 1, k + 1) * h, where h is the level's spacing. */
typedef struct insitu_amr {
  size_t size;
  double origin[3];      /**< the lower corner of cell (0, 0, 0) of every level */
  double spacing[3];     /**< the spacing of the coarsest level; positive */
  int32_t level_count;   /**< 1 to INSITU_AMR_MOST_LEVELS */
  const int32_t* ratios; /**< [level_count - 1] the ratio, 2 or 4, of each level's spacing to the
                              next finer one's, from the coarsest level on; null: all are 2. The
                              library copies them */
  int32_t finest_first;  /**< 0: level 0 is the coarsest; 1: level 0 is the finest */
  insitu_reconstruction reconstruction; /**< how samples, probes, tracers and frames get values */
  int32_t dimensions; /**< 3; or 2: the mesh is a flat one, in the plane whose third coordinate is
                           origin[2]. Its cells have two indices: the third numbers of spacing, of
                           insitu_patch and of insitu_leaves are of no account */
  int32_t reserved;
} insitu_amr;

static inline insitu_amr insitu_amr_default(void) {
  insitu_amr a;
  int i;
  a.size = sizeof a;
  for (i = 0; i < 3; ++i) {
    a.origin[i] = 0.0;
    a.spacing[i] = 1.0;
  }
  a.level_count = 1;
  a.ratios = NULL;
  a.finest_first = 0;
  a.reconstruction = INSITU_DUAL;
  a.dimensions = 3;
  a.reserved = 0;
  return a;
}

/** Makes the mesh an adaptive one, whose pieces are patches or leaves. The first call comes before
 *  the mesh's first piece; a later call changes the lattice or the reconstruction, and the next
 *  commit builds anew. INSITU_ERROR_ARGUMENT: a number is out of range. INSITU_ERROR_ORDER: the
 *  mesh has points, cells or ghosts. On an adaptive mesh insitu_mesh_points, _cells, _block and
 *  _ghosts return INSITU_ERROR_ORDER. */
INSITU_API insitu_status insitu_mesh_amr(insitu_mesh mesh, const insitu_amr* amr);

/** A patch has the cells from lower to lower + cells - 1 of a level; cell (i, j, k) of the patch
 *  has the id i + cells[0]*(j + cells[1]*k). The library masks coarse cells under finer patches.
 *
 *  Where the domain ends at a face of the patch, the solver's ghost cells, which hold its boundary
 *  conditions, can give samples beyond the outermost centres: the library interpolates between a
 *  cell and a ghost as between two cells, so it reproduces a linear field up to the boundary.
 *  ghosts_before and ghosts_after say how many layers of ghosts the arrays of all fields hold
 *  around the patch's cells; the extents and data of these arrays are still those of the cells
 *  alone, and the ghosts lie the strides before and after. The library reads the first layer only,
 *  in commits of INSITU_CHANGED_FIELDS too, across faces only, and only where no cell of the mesh
 *  lies. Ghosts own no point, and no count includes them. At other faces of the domain the value of
 *  the outermost centre is kept; samples are continuous there too. */
typedef struct insitu_patch {
  size_t size;
  int32_t level;
  int64_t lower[3];
  int64_t cells[3];
  int32_t ghosts_before[3]; /**< layers along i, j, k; 0: no layer, or none to be used */
  int32_t ghosts_after[3];
} insitu_patch;

static inline insitu_patch insitu_patch_default(void) {
  insitu_patch p;
  int i;
  p.size = sizeof p;
  p.level = 0;
  for (i = 0; i < 3; ++i)
    p.lower[i] = p.cells[i] = p.ghosts_before[i] = p.ghosts_after[i] = 0;
  return p;
}

/** Makes a piece a patch, or moves an earlier patch elsewhere. The piece's fields have
 *  cells[0]*cells[1]*cells[2] values. Indices lie in -2^30 to 2^30 - 1. INSITU_ERROR_ORDER: the
 *  call came before insitu_mesh_amr. INSITU_ERROR_ARGUMENT: the level, the cells or the ghosts
 *  cannot be. The commit checks how patches fit each other (INSITU_ERROR_MESH), and whether fields
 *  have room for ghosts (INSITU_ERROR_FIELD). After a regrid that leaves fewer patches,
 *  insitu_mesh_drop_pieces drops the last ones. */
INSITU_API insitu_status insitu_mesh_patch(insitu_mesh mesh, int32_t piece,
                                           const insitu_patch* patch);

/** Leaves of octrees, or of quadtrees where insitu_amr has two dimensions; each leaf has a level
 * and the index of its lower corner. */
typedef struct insitu_leaves {
  size_t size;
  insitu_array levels;  /**< uint8, int32 or int64, one a leaf */
  insitu_array corners; /**< int32 or int64, 3 components a leaf, or 2 in two dimensions;
                             component_stride serves separate columns */
  int32_t corner_bits;  /**< -1: a corner counts cells of the leaf's own level; otherwise it counts
                             cells of 1/2^corner_bits of the coarsest level's spacing (p4est:
                             P8EST_MAXLEVEL) */
  int64_t offset[3]; /**< the place of a tree in the forest, added to corners, in the same cells */
} insitu_leaves;

static inline insitu_leaves insitu_leaves_default(void) {
  insitu_leaves l;
  int i;
  l.size = sizeof l;
  l.levels = insitu_array_default();
  l.corners = insitu_array_default();
  l.corner_bits = -1;
  for (i = 0; i < 3; ++i)
    l.offset[i] = 0;
  return l;
}

/** Makes a piece a list of leaves, which may be empty. The arrays are external and lie in host
 *  memory (see insitu_array; items may lie behind pointers). The call implies
 *  INSITU_CHANGED_TOPOLOGY; a commit of that checks every leaf, and its INSITU_ERROR_MESH names the
 *  first leaf whose level or corner cannot be. INSITU_ERROR_ORDER: the call came before
 *  insitu_mesh_amr. INSITU_ERROR_ARGUMENT: the arrays do not fit. */
INSITU_API insitu_status insitu_mesh_leaves(insitu_mesh mesh, int32_t piece,
                                            const insitu_leaves* leaves);

/** What the last regrid of an adaptive mesh made, in cells unless said otherwise. */
typedef struct insitu_amr_info {
  size_t size;
  int64_t leaves, masked; /**< masked: cells under finer cells */
  int64_t gridlets;       /**< small grids of cubes, by number */
  int64_t cubes;          /**< dual cells in gridlets */
  int64_t stitching;      /**< dual cells outside gridlets */
  int64_t folded;         /**< stitching cells that were folded before the repair */
  int64_t repaired;       /**< leaves that were split for the dual mesh alone */
  int64_t bytes;          /**< memory of the dual mesh; values and tree are left out */
  double build_s;
  int64_t by_places; /**< 1: cubes lie in gridlets, and points find dual cells by their places; 0:
                          there are no gridlets, as they do not pay where three cells in four
                          are no cubes, and points go by the tree; or there is no dual mesh */
} insitu_amr_info;

static inline insitu_amr_info insitu_amr_info_default(void) {
  insitu_amr_info i;
  i.size = sizeof i;
  i.leaves = i.masked = i.gridlets = i.cubes = i.stitching = i.folded = i.repaired = i.bytes = 0;
  i.build_s = 0.0;
  i.by_places = 0;
  return i;
}

/** Writes what the last regrid made. INSITU_ERROR_ORDER: the mesh is not adaptive, or not
 *  committed. */
INSITU_API insitu_status insitu_mesh_amr_info(insitu_mesh mesh, insitu_amr_info* info);

/** Writes the levels of the cells that answers name (insitu_locate_args), as the solver numbers
 *  levels. count: the length of cells, pieces and levels. cells: ids within their pieces, where the
 *  first cell of a piece has the id cell_base, 0 or 1. pieces: the cells' pieces; null serves a
 *  mesh of one piece. levels: memory of the caller, which gets -1 for an answer that is outside: a
 *  cell of cell_base - 1, or a piece of -1. INSITU_ERROR_ORDER: the mesh is not adaptive, or not
 *  committed. INSITU_ERROR_ARGUMENT: an array is null, or the mesh has no such cell or piece, whose
 *  index the message gives; the levels before it are written. */
INSITU_API insitu_status insitu_mesh_cell_levels(insitu_mesh mesh, int64_t count,
                                                 const int64_t* cells, const int32_t* pieces,
                                                 int64_t cell_base, int32_t* levels);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_AMR_H */
