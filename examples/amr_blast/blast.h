/* Finite volumes for the Euler equations on a p8est forest, one step for all levels: limited linear
 * reconstruction, HLLC fluxes (HLL beside shocks, which HLLC lets run ahead along the grid), Heun's
 * method in time; or all of first order. Refined where density or pressure jump. What one cell
 * loses through a face its neighbour gains, across hanging faces too, so mass and energy are
 * conserved to rounding.
 *
 * On several processes p8est deals out the cells. A process knows its neighbours' cells beside its
 * own as ghosts, whose values are theirs, and adds up what goes through the faces of a cell in the
 * order of one process: so all results are the same to the bit on any number of them. Functions
 * that are given a solver are called by all its processes alike, and return the same, unless they
 * are said to be local. */
#ifndef AMR_BLAST_H
#define AMR_BLAST_H

#include <p8est.h>
#include <p8est_ghost.h>
#include <stddef.h>
#include <stdint.h>

#include "gas.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Primitive values at a point. */
typedef void (*blast_initial)(const double x[3], const void* data, double w[GAS_VALUES]);

typedef struct blast_config {
  int trees[3];     /* of the brick */
  double tree_size; /* edge of a tree; the brick begins at the origin */
  int periodic;     /* 1: the brick's sides are joined; 0: they reflect */
  int coarsest;     /* levels that cells may have: a tree's own is 0 */
  int finest;
  double gamma;   /* ratio of heats */
  int order;      /* 1 or 2 */
  double courant; /* below 1, for order 2 at most 0.5 */
  double refine;  /* where density or pressure differ by this share between neighbours ... */
  double coarsen; /* ... and where they differ less than this in eight siblings */
  int margin;     /* cells around those that are refined too */
  blast_initial initial;
  const void* data; /* for initial */
} blast_config;

blast_config blast_config_default(void);

/* A ball of gas under pressure in gas at rest: what initial does by default. */
typedef struct blast_ball {
  double centre[3], radius;
  double density, pressure;                 /* inside */
  double ambient_density, ambient_pressure; /* outside */
} blast_ball;
void blast_ball_initial(const double x[3], const void* ball, double w[GAS_VALUES]);

/* A cell's record, behind its quadrant's p.user_data. The first five are what libinsitu reads. */
typedef struct blast_cell {
  double density, pressure, velocity[3];
  double level;
  double checkers; /* 0 and 1 in turns; 2 where a neighbour has another level */
  double u[GAS_VALUES];
  double jump;   /* largest to a neighbour, of density or pressure; at the last regrid */
  int wanted;    /* above 0: finer, -1: coarser */
  size_t number; /* in the order of the lists below */
} blast_cell;

/* What a step needs of a cell, apart from the record, which p8est copies about. */
typedef struct blast_work {
  double size;                 /* edge */
  double gain[GAS_VALUES];     /* through its faces, in a unit of time */
  double before[GAS_VALUES];   /* u at the beginning of the step */
  double slope[3][GAS_VALUES]; /* of the primitive values, limited */
  double other[3][GAS_VALUES]; /* towards the upper neighbours, until slope is limited */
  int is_steep;                /* pressure jumps to a neighbour as in a shock */
} blast_work;

/* A face, or a quarter of one where the neighbour is finer. */
typedef struct blast_face {
  blast_cell *lower, *upper; /* null: a wall */
  double size;               /* edge */
  int axis;
  int quarter; /* which, bit 0 along the first of the other two axes; -1: a whole face */
} blast_face;

typedef struct blast_solver {
  blast_config config;
  p8est_connectivity_t* connectivity;
  p8est_t* forest;
  blast_cell** cells; /* [forest->local_num_quadrants], in p8est's order */
  blast_work* work;   /* the same, and then those of the ghosts */
  int64_t* numbers;   /* of the cells, among those of all processes */
  blast_face* faces;
  size_t face_count, face_room;
  p8est_ghost_t* ghost;    /* null on one process */
  blast_cell* ghost_cells; /* in the order of ghost->ghosts */
  void** mirrors;          /* room for as many addresses as cells are others' ghosts */
  double time;
  long cycle;
} blast_solver;

/* The initial state on cells that are refined for it. Null: no memory, or the configuration is not
 * one (finest above P8EST_QMAXLEVEL - 1 or below coarsest, nothing positive ...). */
blast_solver* blast_new(const blast_config* config, sc_MPI_Comm comm);
void blast_free(blast_solver* solver);

/* One step, no longer than `longest`; returns its length, or -1 and changes nothing more if a
 * cell's density or pressure stopped being positive. */
double blast_step(blast_solver* solver, double longest);

/* Refines and coarsens for the present state. Returns 1 if cells changed or moved, 0 if not, -1 if
 * there is no memory. */
int blast_regrid(blast_solver* solver);

/* Sums of the conserved values over all cells: mass, momentum (3), energy. */
void blast_totals(const blast_solver* solver, double totals[GAS_VALUES]);

/* Local: the centre of cell i. */
void blast_centre(const blast_solver* solver, size_t i, double centre[3]);

/* Local. Of the record: from u; 0 if density or pressure is not positive. */
int blast_update_primitives(blast_cell* cell, double gamma);
void blast_primitives(const blast_cell* cell, double w[GAS_VALUES]);

/* grid.c: lists of cells, ghosts and faces, from the forest as it is; 0 if there is no memory. */
int blast_list_cells(blast_solver* solver);

/* processes.c: ghosts get what their own processes have of their records, and of their work. */
void blast_exchange_cells(blast_solver* solver);
void blast_exchange_work(blast_solver* solver);

double blast_largest(const blast_solver* solver, double mine);
int blast_all(const blast_solver* solver, int good); /* 1 if it is good on all */

/* A sum over all cells, which is the same to the bit however they are dealt out. */
typedef double (*blast_term)(const blast_solver* solver, size_t i, int which);
double blast_sum(const blast_solver* solver, blast_term term, int which);

#ifdef __cplusplus
}
#endif

#endif
