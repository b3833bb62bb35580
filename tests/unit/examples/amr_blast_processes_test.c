/* The blast on several processes (mpirun -n 3 amr_blast_processes_test): every number that a
 * process has is the one of a run on one process, to the bit, and so is the grid. Each process
 * makes that run too, and compares. */
#include <p4est.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "blast.h"

static int failures = 0, rank = 0;

static void expect(int holds, const char* name, const char* what) {
  if (!holds && failures++ < 5)
    fprintf(stderr, "process %d, %s: %s\n", rank, name, what);
}

/* p8est deals out the cells in its order, so a process has some that follow each other. */
static void compare(const blast_solver* part, const blast_solver* whole, const char* name) {
  const size_t n = (size_t)part->forest->local_num_quadrants;
  const size_t first = (size_t)part->forest->global_first_quadrant[rank];
  double here[GAS_VALUES], there[GAS_VALUES];
  size_t i;
  expect(part->forest->global_num_quadrants == whole->forest->local_num_quadrants, name,
         "another number of cells");
  if (failures > 0)
    return;
  for (i = 0; i < n; ++i) {
    const blast_cell *const p = part->cells[i], *const w = whole->cells[first + i];
    double x[3], y[3];
    blast_centre(part, i, x);
    blast_centre(whole, first + i, y);
    expect(memcmp(x, y, sizeof x) == 0, name, "a cell lies elsewhere");
    expect(memcmp(&p->density, &w->density, sizeof p->density) == 0, name, "density");
    expect(memcmp(&p->pressure, &w->pressure, sizeof p->pressure) == 0, name, "pressure");
    expect(memcmp(p->velocity, w->velocity, sizeof p->velocity) == 0, name, "velocity");
    expect(memcmp(&p->level, &w->level, sizeof p->level) == 0, name, "level");
    expect(memcmp(&p->checkers, &w->checkers, sizeof p->checkers) == 0, name, "checkers");
    expect(memcmp(p->u, w->u, sizeof p->u) == 0, name, "a conserved value");
  }
  blast_totals(part, here);
  blast_totals(whole, there);
  expect(memcmp(here, there, sizeof here) == 0, name, "a total");
}

static void run(const blast_config* config, int cycles, const char* name) {
  blast_solver* const part = blast_new(config, sc_MPI_COMM_WORLD);
  blast_solver* const whole = blast_new(config, sc_MPI_COMM_SELF);
  int i;
  expect(part && whole, name, "no solver");
  if (!part || !whole)
    return;
  compare(part, whole, name);
  for (i = 1; i <= cycles; ++i) {
    expect(blast_step(part, 1.0) == blast_step(whole, 1.0), name, "a timestep");
    if (i % 4 == 0)
      expect(blast_regrid(part) >= 0 && blast_regrid(whole) >= 0, name, "no memory");
  }
  compare(part, whole, name);
  blast_free(part);
  blast_free(whole);
}

int main(int argc, char** argv) {
  blast_config config = blast_config_default();
  int most = 0;
  if (sc_MPI_Init(&argc, &argv) != sc_MPI_SUCCESS)
    return EXIT_FAILURE;
  sc_MPI_Comm_rank(sc_MPI_COMM_WORLD, &rank);
  p4est_init(NULL, SC_LP_ERROR);
  config.coarsest = 1;
  config.finest = 3;
  run(&config, 24, "walls");
  config.periodic = 1;
  run(&config, 16, "periodic");
  config.order = 1;
  config.trees[0] = config.trees[1] = config.trees[2] = 1;
  config.coarsest = config.finest = 0; /* one cell, so that most processes have none */
  run(&config, 4, "one cell");
  sc_MPI_Allreduce(&failures, &most, 1, sc_MPI_INT, sc_MPI_MAX, sc_MPI_COMM_WORLD);
  sc_finalize();
  return sc_MPI_Finalize() == sc_MPI_SUCCESS && most == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
