#include "blast.h"

#include <math.h>
#include <p8est_extended.h>
#include <stdlib.h>

static const blast_ball default_ball = {{1.0, 1.0, 1.0}, 0.25, 1.0, 10.0, 1.0, 0.1};

blast_config blast_config_default(void) {
  blast_config c;
  c.trees[0] = 3;
  c.trees[1] = c.trees[2] = 2;
  c.tree_size = 1.0;
  c.periodic = 0;
  c.coarsest = 2;
  c.finest = 5;
  c.gamma = 1.4;
  c.order = 2;
  c.courant = 0.45;
  c.refine = 0.08;
  c.coarsen = 0.03;
  c.margin = 2;
  c.initial = blast_ball_initial;
  c.data = &default_ball;
  return c;
}

void blast_ball_initial(const double x[3], const void* ball, double w[GAS_VALUES]) {
  const blast_ball* const b = ball;
  double square = 0.0;
  int a;
  for (a = 0; a < 3; ++a) {
    square += (x[a] - b->centre[a]) * (x[a] - b->centre[a]);
    w[1 + a] = 0.0;
  }
  w[0] = square < b->radius * b->radius ? b->density : b->ambient_density;
  w[4] = square < b->radius * b->radius ? b->pressure : b->ambient_pressure;
}

int blast_update_primitives(blast_cell* cell, double gamma) {
  double w[GAS_VALUES];
  int a;
  gas_primitive(cell->u, gamma, w);
  if (!(w[0] > 0.0 && w[4] > 0.0))
    return 0;
  cell->density = w[0];
  for (a = 0; a < 3; ++a)
    cell->velocity[a] = w[1 + a];
  cell->pressure = w[4];
  return 1;
}

void blast_primitives(const blast_cell* cell, double w[GAS_VALUES]) {
  int a;
  w[0] = cell->density;
  for (a = 0; a < 3; ++a)
    w[1 + a] = cell->velocity[a];
  w[4] = cell->pressure;
}

/* The conserved values' mean over the cell, by SAMPLES^3 midpoints. */
static void fill(const blast_solver* s, size_t i) {
  enum { SAMPLES = 4 };
  blast_cell* const cell = s->cells[i];
  double centre[3], x[3], w[GAS_VALUES], u[GAS_VALUES];
  int n, k;
  blast_centre(s, i, centre);
  for (k = 0; k < GAS_VALUES; ++k)
    cell->u[k] = 0.0;
  for (n = 0; n < SAMPLES * SAMPLES * SAMPLES; ++n) {
    const int at[3] = {n % SAMPLES, n / SAMPLES % SAMPLES, n / (SAMPLES * SAMPLES)};
    for (k = 0; k < 3; ++k)
      x[k] = centre[k] + s->work[i].size * ((at[k] + 0.5) / SAMPLES - 0.5);
    s->config.initial(x, s->config.data, w);
    gas_conserved(w, s->config.gamma, u);
    for (k = 0; k < GAS_VALUES; ++k)
      cell->u[k] += u[k] / (SAMPLES * SAMPLES * SAMPLES);
  }
}

static int fill_all(const blast_solver* s) {
  size_t i;
  int good = 1;
  for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i) {
    fill(s, i);
    good = blast_update_primitives(s->cells[i], s->config.gamma) && good;
  }
  return blast_all(s, good);
}

static int is_sound(const blast_config* c) {
  return c->trees[0] > 0 && c->trees[1] > 0 && c->trees[2] > 0 && c->tree_size > 0.0 &&
         c->coarsest >= 0 && c->finest >= c->coarsest && c->finest < P8EST_QMAXLEVEL &&
         c->gamma > 1.0 && (c->order == 1 || c->order == 2) && c->courant > 0.0 &&
         c->courant < (c->order == 1 ? 1.0 : 0.51) && c->coarsen <= c->refine && c->margin >= 0 &&
         c->initial;
}

blast_solver* blast_new(const blast_config* config, sc_MPI_Comm comm) {
  const blast_config* const c = config;
  blast_solver* s;
  int level, good;
  if (!is_sound(c) || !(s = calloc(1, sizeof *s)))
    return NULL;
  s->config = *c;
  s->connectivity = p8est_connectivity_new_brick(c->trees[0], c->trees[1], c->trees[2], c->periodic,
                                                 c->periodic, c->periodic);
  s->forest = p8est_new_ext(comm, s->connectivity, 0, c->coarsest, 1, sizeof(blast_cell), NULL, s);
  p8est_partition(s->forest, 1, NULL);
  good = blast_list_cells(s) && fill_all(s);
  for (level = c->coarsest; good && level < c->finest; ++level) {
    const int changed = blast_regrid(s);
    good = changed >= 0 && fill_all(s); /* not from the coarser cells */
    if (changed == 0)
      break;
  }
  if (good)
    return s;
  blast_free(s);
  return NULL;
}

void blast_free(blast_solver* s) {
  if (!s)
    return;
  if (s->ghost)
    p8est_ghost_destroy(s->ghost);
  if (s->forest)
    p8est_destroy(s->forest);
  if (s->connectivity)
    p8est_connectivity_destroy(s->connectivity);
  free(s->cells);
  free(s->work);
  free(s->numbers);
  free(s->faces);
  free(s->ghost_cells);
  free(s->mirrors);
  free(s);
}

static double content(const blast_solver* s, size_t i, int k) {
  return s->work[i].size * s->work[i].size * s->work[i].size * s->cells[i]->u[k];
}

void blast_totals(const blast_solver* s, double totals[GAS_VALUES]) {
  int k;
  for (k = 0; k < GAS_VALUES; ++k)
    totals[k] = blast_sum(s, content, k);
}
