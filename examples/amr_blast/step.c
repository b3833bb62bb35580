/* One step of a blast_solver. */
#include <math.h>
#include <string.h>

#include "blast.h"

static double step_length(const blast_solver* s, double longest) {
  double fastest = 0.0; /* how many cells waves cross in a unit of time */
  size_t i;
  for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i) {
    double w[GAS_VALUES], rate;
    blast_primitives(s->cells[i], w);
    rate = (fabs(w[1]) + fabs(w[2]) + fabs(w[3]) + 3.0 * gas_sound_speed(w, s->config.gamma)) /
           s->work[i].size;
    fastest = fmax(fastest, rate);
  }
  return fmin(longest, s->config.courant / blast_largest(s, fastest));
}

static double smaller_of_equal_sign(double a, double b) {
  return a * b <= 0.0 ? 0.0 : fabs(a) < fabs(b) ? a : b;
}

/* Differences to the neighbours, those over quarters of a face averaged; then the smaller one along
 * each axis. At walls there is none, so the slope is 0. */
static void find_slopes(blast_solver* s) {
  const double steep = 0.5;
  size_t i;
  int a, k;
  for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i) {
    memset(s->work[i].slope, 0, sizeof s->work[i].slope);
    memset(s->work[i].other, 0, sizeof s->work[i].other);
    s->work[i].is_steep = 0;
  }
  for (i = 0; i < s->face_count; ++i) {
    const blast_face* const f = s->faces + i;
    double l[GAS_VALUES], u[GAS_VALUES], distance;
    blast_work *lower, *upper;
    if (!f->lower || !f->upper)
      continue;
    lower = s->work + f->lower->number;
    upper = s->work + f->upper->number;
    distance = 0.5 * (lower->size + upper->size);
    blast_primitives(f->lower, l);
    blast_primitives(f->upper, u);
    for (k = 0; k < GAS_VALUES; ++k) {
      const double slope = (u[k] - l[k]) / distance, area = f->size * f->size;
      lower->other[f->axis][k] += slope * (area / (lower->size * lower->size));
      upper->slope[f->axis][k] += slope * (area / (upper->size * upper->size));
    }
    if (fabs(u[4] - l[4]) > steep * fmin(u[4], l[4]))
      lower->is_steep = upper->is_steep = 1;
  }
  for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i)
    for (a = 0; a < 3; ++a)
      for (k = 0; k < GAS_VALUES; ++k)
        s->work[i].slope[a][k] =
            smaller_of_equal_sign(s->work[i].slope[a][k], s->work[i].other[a][k]);
}

/* A cell's values at the middle of one of its faces, side 1 the upper one. */
static void at_face(const blast_solver* s, const blast_cell* cell, const blast_face* f, int side,
                    double w[GAS_VALUES]) {
  const blast_work* const work = s->work + cell->number;
  double mean[GAS_VALUES];
  int a, k, bit = 0;
  blast_primitives(cell, mean);
  memcpy(w, mean, sizeof mean);
  if (s->config.order == 1)
    return;
  for (a = 0; a < 3; ++a) {
    double offset = 0.0;
    if (a == f->axis)
      offset = side ? 0.5 * work->size : -0.5 * work->size;
    else if (f->size < work->size) /* the middle of a quarter of its face */
      offset = f->quarter >> bit & 1 ? 0.5 * f->size : -0.5 * f->size;
    bit += a != f->axis;
    for (k = 0; k < GAS_VALUES; ++k)
      w[k] += offset * work->slope[a][k];
  }
  if (!(w[0] > 0.0 && w[4] > 0.0))
    memcpy(w, mean, sizeof mean);
}

static void cross(blast_solver* s, const blast_face* f) {
  double flux[GAS_VALUES], l[GAS_VALUES], u[GAS_VALUES];
  blast_work* const lower = f->lower ? s->work + f->lower->number : NULL;
  blast_work* const upper = f->upper ? s->work + f->upper->number : NULL;
  int k;
  if (f->lower)
    at_face(s, f->lower, f, 1, l);
  if (f->upper)
    at_face(s, f->upper, f, 0, u);
  if (!lower || !upper)
    gas_wall_flux(lower ? l : u, f->axis, lower ? 1 : -1, s->config.gamma, flux);
  else if (lower->is_steep || upper->is_steep)
    gas_diffusive_flux(l, u, f->axis, s->config.gamma, flux);
  else
    gas_flux(l, u, f->axis, s->config.gamma, flux);
  for (k = 0; k < GAS_VALUES; ++k) {
    const double crossing = f->size * f->size * flux[k];
    if (lower)
      lower->gain[k] -= crossing;
    if (upper)
      upper->gain[k] += crossing;
  }
}

static void find_gains(blast_solver* s) {
  size_t i;
  for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i)
    memset(s->work[i].gain, 0, sizeof s->work[i].gain);
  blast_exchange_cells(s);
  find_slopes(s);
  blast_exchange_work(s);
  for (i = 0; i < s->face_count; ++i)
    cross(s, s->faces + i);
}

/* u = (1 - share) * before + share * (u + dt * gain); 0 if that is no gas. */
static int move_on(blast_solver* s, double dt, double share) {
  size_t i;
  int k, good = 1;
  for (i = 0; good && i < (size_t)s->forest->local_num_quadrants; ++i) {
    blast_cell* const cell = s->cells[i];
    const blast_work* const work = s->work + i;
    const double volume = work->size * work->size * work->size;
    for (k = 0; k < GAS_VALUES; ++k) {
      const double next = cell->u[k] + dt / volume * work->gain[k];
      cell->u[k] = share == 1.0 ? next : (1.0 - share) * work->before[k] + share * next;
    }
    good = blast_update_primitives(cell, s->config.gamma);
  }
  return blast_all(s, good);
}

double blast_step(blast_solver* s, double longest) {
  const double dt = step_length(s, longest);
  size_t i;
  for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i)
    memcpy(s->work[i].before, s->cells[i]->u, sizeof s->work[i].before);
  find_gains(s);
  if (!move_on(s, dt, 1.0))
    return -1.0;
  if (s->config.order == 2) {
    find_gains(s);
    if (!move_on(s, dt, 0.5))
      return -1.0;
  }
  s->time += dt;
  ++s->cycle;
  return dt;
}
