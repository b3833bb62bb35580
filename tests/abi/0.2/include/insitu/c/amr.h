/** @file amr.h
 *  Adaptive meshes: cell-centred patches of levels, or leaves of octrees, as the solver stores
 *  them. Values are given by insitu_mesh_field with INSITU_CELL; extents and strides of the arrays
 *  say where ghost layers are left out, and C order. Between cell centres they are interpolated on
 *  the dual mesh, which a commit of INSITU_CHANGED_TOPOLOGY (a regrid) builds; other commits keep
 *  it. */
#ifndef INSITU_C_AMR_H
#define INSITU_C_AMR_H

#include "insitu/c/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { INSITU_AMR_MOST_LEVELS = 31 };

/** What an adaptive mesh's samples are between cell centres. */
typedef enum insitu_reconstruction INSITU_INT {
  INSITU_DUAL = 0,   /**< continuous: the dual mesh's interpolant, the cells' values at their
                          centres; from the outermost centres to the boundary the value is kept,
                          or goes on towards the ghost cells of insitu_patch. It may jump
                          in planes in which the domain ends in the midst of a coarser
                          cell's face */
  INSITU_NEAREST = 1 /**< the value of the cell that holds the point */
} insitu_reconstruction;

/** The lattices of an adaptive mesh's levels. Cell (i, j, k) of a level spans from origin +
 *  (i, j, k) * h to one h more along each axis; h is the level's spacing. */
typedef struct insitu_amr {
  size_t size;
  double origin[3];      /**< the lower corner of cell (0, 0, 0) of every level */
  double spacing[3];     /**< of the coarsest level; positive */
  int32_t level_count;   /**< 1 to INSITU_AMR_MOST_LEVELS */
  const int32_t* ratios; /**< [level_count - 1] from the coarsest on: 2 or 4; null: all 2; copied */
  int32_t finest_first;  /**< 0: level 0 is the coarsest; 1: level 0 is the finest */
  insitu_reconstruction reconstruction; /**< of samples, probes, tracers and frames */
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
  return a;
}

/** Makes the mesh an adaptive one: its pieces are patches or leaves. Before its first piece;
 *  again to change the lattice or the reconstruction, for which the next commit builds anew.
 *  INSITU_ERROR_ARGUMENT: a number out of range. INSITU_ERROR_ORDER: the mesh has points, cells or
 *  ghosts. On an adaptive mesh insitu_mesh_points, _cells, _block and _ghosts are
 *  INSITU_ERROR_ORDER. */
INSITU_API insitu_status insitu_mesh_amr(insitu_mesh mesh, const insitu_amr* amr);

/** A patch: the cells lower to lower + cells - 1 of a level; cell (i, j, k) of it has the id
 *  i + cells[0]*(j + cells[1]*k). Coarse cells under finer patches are masked by the library.
 *
 *  Where the domain ends at the patch's faces, the solver's ghost cells, which hold its boundary
 *  conditions, can give samples from the outermost centres on: between a cell and a ghost they are
 *  as between two cells, so a linear field is reproduced up to the boundary. ghosts_before and
 *  ghosts_after say how many layers of ghosts the arrays of all fields hold around these cells
 *  (extents and data are still those of the cells alone, and ghosts lie the strides before and
 *  after). The first layer is read, by commits of INSITU_CHANGED_FIELDS too, across faces only, and
 *  only where no cell of the mesh lies. Ghosts own no point and are counted nowhere. At other faces
 *  of the domain the value of the outermost centre is kept; samples are continuous all the same. */
typedef struct insitu_patch {
  size_t size;
  int32_t level;
  int64_t lower[3];
  int64_t cells[3];
  int32_t ghosts_before[3]; /**< layers along i, j, k; 0: none, or not to be used */
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

/** A piece that is a patch, or another place for it. Its fields have cells[0]*cells[1]*cells[2]
 *  values. Indices lie in -2^30 to 2^30 - 1. INSITU_ERROR_ORDER before insitu_mesh_amr;
 *  INSITU_ERROR_ARGUMENT: a level, cells or ghosts that cannot be. How patches fit each other is
 *  checked by the commit (INSITU_ERROR_MESH), and whether fields have room for ghosts
 *  (INSITU_ERROR_FIELD). A regrid that leaves fewer patches: insitu_mesh_drop_pieces. */
INSITU_API insitu_status insitu_mesh_patch(insitu_mesh mesh, int32_t piece,
                                           const insitu_patch* patch);

/** Leaves of octrees: a level and the lower corner's index each. */
typedef struct insitu_leaves {
  size_t size;
  insitu_array levels;  /**< uint8, int32 or int64, one a leaf */
  insitu_array corners; /**< int32 or int64: 3 components a leaf;
                             component_stride serves separate columns */
  int32_t
      corner_bits;   /**< -1: a corner counts cells of the leaf's own level; otherwise cells of
                          1/2^corner_bits of the coarsest level's spacing (p4est: P8EST_MAXLEVEL) */
  int64_t offset[3]; /**< added to corners, in the same cells: where a tree lies in the forest */
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

/** A piece that is a list of leaves; none at all is fine. The arrays are external, in host memory
 *  (see insitu_array; they may lie behind pointers). A commit of INSITU_CHANGED_TOPOLOGY, which
 *  this call says too, checks every leaf: INSITU_ERROR_MESH names the first whose level or corner
 *  cannot be. INSITU_ERROR_ORDER before insitu_mesh_amr;
 *  INSITU_ERROR_ARGUMENT: arrays that do not fit. */
INSITU_API insitu_status insitu_mesh_leaves(insitu_mesh mesh, int32_t piece,
                                            const insitu_leaves* leaves);

/** What an adaptive mesh's last regrid made, in cells. */
typedef struct insitu_amr_info {
  size_t size;
  int64_t leaves, masked; /**< masked: under finer cells */
  int64_t gridlets;       /**< small grids of cubes */
  int64_t cubes;          /**< dual cells in them */
  int64_t stitching;      /**< other dual cells */
  int64_t folded;         /**< of these, folded before the repair */
  int64_t repaired;       /**< leaves that were split for the dual mesh alone */
  int64_t bytes;          /**< of the dual mesh, values and tree left out */
  double build_s;
} insitu_amr_info;

static inline insitu_amr_info insitu_amr_info_default(void) {
  insitu_amr_info i;
  i.size = sizeof i;
  i.leaves = i.masked = i.gridlets = i.cubes = i.stitching = i.folded = i.repaired = i.bytes = 0;
  i.build_s = 0.0;
  return i;
}

/** INSITU_ERROR_ORDER unless the mesh is adaptive and committed. */
INSITU_API insitu_status insitu_mesh_amr_info(insitu_mesh mesh, insitu_amr_info* info);

/** The levels of cells that answers name (insitu_locate_args), as the solver numbers levels.
 *  count: of cells, pieces and levels. cells: ids within their pieces, the first of which is
 *  cell_base, 0 or 1; pieces: theirs, or null where the mesh has one piece. levels: the caller's;
 *  -1 for what is outside: a cell of cell_base - 1, or a piece of -1.
 *  INSITU_ERROR_ORDER unless the mesh is adaptive and committed; INSITU_ERROR_ARGUMENT: a null
 *  array, or a cell or piece that there is none of, with its index; levels before it are set. */
INSITU_API insitu_status insitu_mesh_cell_levels(insitu_mesh mesh, int64_t count,
                                                 const int64_t* cells, const int32_t* pieces,
                                                 int64_t cell_base, int32_t* levels);

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_AMR_H */
