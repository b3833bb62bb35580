/* What a blast_solver asks of the other processes: their cells beside its own, and agreement. One
 * process does without. */
#include <math.h>

#include "blast.h"

/* To the processes that have this one's cells as ghosts, and from those that have its ghosts. */
static void exchange(const blast_solver* s, size_t size, void* ghosts) {
  p8est_ghost_exchange_custom(s->forest, s->ghost, size, s->mirrors, ghosts);
}

void blast_exchange_cells(blast_solver* s) {
  size_t i;
  if (!s->ghost)
    return;
  for (i = 0; i < s->ghost->mirrors.elem_count; ++i) {
    const p8est_quadrant_t* const q = p8est_quadrant_array_index(&s->ghost->mirrors, i);
    s->mirrors[i] = s->cells[q->p.piggy3.local_num];
  }
  exchange(s, sizeof *s->ghost_cells, s->ghost_cells);
  for (i = 0; i < s->ghost->ghosts.elem_count; ++i)
    s->ghost_cells[i].number = (size_t)s->forest->local_num_quadrants + i;
}

void blast_exchange_work(blast_solver* s) {
  size_t i;
  if (!s->ghost)
    return;
  for (i = 0; i < s->ghost->mirrors.elem_count; ++i) {
    const p8est_quadrant_t* const q = p8est_quadrant_array_index(&s->ghost->mirrors, i);
    s->mirrors[i] = s->work + q->p.piggy3.local_num;
  }
  exchange(s, sizeof *s->work, s->work + s->forest->local_num_quadrants);
}

double blast_largest(const blast_solver* s, double mine) {
  double largest = mine;
  sc_MPI_Allreduce(&mine, &largest, 1, sc_MPI_DOUBLE, sc_MPI_MAX, s->forest->mpicomm);
  return largest;
}

int blast_all(const blast_solver* s, int good) {
  return blast_largest(s, good ? 0.0 : 1.0) == 0.0;
}

/* Each term becomes a whole multiple of a coarse unit and one of a fine unit for the rest, 2^30 at
 * most both. Sums of fewer than 2^33 whole numbers are exact, so their order does not matter. */
double blast_sum(const blast_solver* s, blast_term term, int which) {
  const size_t n = (size_t)s->forest->local_num_quadrants;
  long long mine[2] = {0, 0}, sums[2] = {0, 0};
  double bound = 0.0, coarse, fine;
  size_t i;
  int exponent;
  for (i = 0; i < n; ++i)
    bound = fmax(bound, fabs(term(s, i, which)));
  bound = blast_largest(s, bound);
  if (!(bound > 0.0 && bound < HUGE_VAL))
    return bound;
  frexp(bound, &exponent);
  coarse = ldexp(1.0, exponent - 30);
  fine = ldexp(coarse, -31);
  for (i = 0; i < n; ++i) {
    const double value = term(s, i, which), multiple = nearbyint(value / coarse);
    mine[0] += (long long)multiple;
    mine[1] += (long long)nearbyint((value - multiple * coarse) / fine);
  }
  sc_MPI_Allreduce(mine, sums, 2, sc_MPI_LONG_LONG_INT, sc_MPI_SUM, s->forest->mpicomm);
  return (double)sums[0] * coarse + (double)sums[1] * fine;
}
