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
  c.courant = 0.8;
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

/* From the conserved values; 0 if density or pressure is not positive. */
static int update_primitives(blast_cell* cell, double gamma) {
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

static void primitives(const blast_cell* cell, double w[GAS_VALUES]) {
  int a;
  w[0] = cell->density;
  for (a = 0; a < 3; ++a)
    w[1 + a] = cell->velocity[a];
  w[4] = cell->pressure;
}

static double volume(const blast_solver* s, size_t i) {
  return s->sizes[i] * s->sizes[i] * s->sizes[i];
}

/* The conserved values' mean over the cell, by samples[]^3 midpoints. */
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
      x[k] = centre[k] + s->sizes[i] * ((at[k] + 0.5) / SAMPLES - 0.5);
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
    good = update_primitives(s->cells[i], s->config.gamma) && good;
  }
  return good;
}

static int is_sound(const blast_config* c) {
  return c->trees[0] > 0 && c->trees[1] > 0 && c->trees[2] > 0 && c->tree_size > 0.0 &&
         c->coarsest >= 0 && c->finest >= c->coarsest && c->finest < P8EST_QMAXLEVEL &&
         c->gamma > 1.0 && c->courant > 0.0 && c->courant < 1.0 && c->coarsen <= c->refine &&
         c->margin >= 0 && c->initial;
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
  if (s->forest)
    p8est_destroy(s->forest);
  if (s->connectivity)
    p8est_connectivity_destroy(s->connectivity);
  free(s->cells);
  free(s->sizes);
  free(s->faces);
  free(s);
}

static double step_length(const blast_solver* s, double longest) {
  double fastest = 0.0; /* how many cells waves cross in a unit of time */
  size_t i;
  for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i) {
    double w[GAS_VALUES], rate;
    primitives(s->cells[i], w);
    rate = (fabs(w[1]) + fabs(w[2]) + fabs(w[3]) + 3.0 * gas_sound_speed(w, s->config.gamma)) /
           s->sizes[i];
    fastest = fmax(fastest, rate);
  }
  return fmin(longest, s->config.courant / fastest);
}

static void exchange(const blast_solver* s, const blast_face* f) {
  double flux[GAS_VALUES], l[GAS_VALUES], u[GAS_VALUES];
  int k;
  if (f->lower)
    primitives(f->lower, l);
  if (f->upper)
    primitives(f->upper, u);
  if (f->lower && f->upper)
    gas_flux(l, u, f->axis, s->config.gamma, flux);
  else if (f->lower)
    gas_wall_flux(l, f->axis, 1, s->config.gamma, flux);
  else
    gas_wall_flux(u, f->axis, -1, s->config.gamma, flux);
  for (k = 0; k < GAS_VALUES; ++k) {
    const double crossing = f->area * flux[k];
    if (f->lower)
      f->lower->gain[k] -= crossing;
    if (f->upper)
      f->upper->gain[k] += crossing;
  }
}

double blast_step(blast_solver* s, double longest) {
  const double dt = step_length(s, longest);
  size_t i;
  int k;
  for (i = 0; i < s->face_count; ++i)
    exchange(s, s->faces + i);
  for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i) {
    blast_cell* const cell = s->cells[i];
    for (k = 0; k < GAS_VALUES; ++k) {
      cell->u[k] += dt / volume(s, i) * cell->gain[k];
      cell->gain[k] = 0.0;
    }
    if (!update_primitives(cell, s->config.gamma))
      return -1.0;
  }
  s->time += dt;
  ++s->cycle;
  return dt;
}

/* Neumaier's sums, so that the totals are no less exact than what is summed. */
void blast_totals(const blast_solver* s, double totals[GAS_VALUES]) {
  size_t i;
  int k;
  for (k = 0; k < GAS_VALUES; ++k) {
    double sum = 0.0, rest = 0.0;
    for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i) {
      const double term = volume(s, i) * s->cells[i]->u[k], next = sum + term;
      rest += fabs(sum) >= fabs(term) ? (sum - next) + term : (term - next) + sum;
      sum = next;
    }
    totals[k] = sum + rest;
  }
}
