/* The grid of a blast_solver: lists of cells and faces, and what is refined. */
#include <math.h>
#include <p8est_bits.h>
#include <p8est_extended.h>
#include <p8est_iterate.h>
#include <stdlib.h>
#include <string.h>

#include "blast.h"

static blast_cell* cell_of(const p8est_quadrant_t* q) {
  return (blast_cell*)q->p.user_data;
}

/* Where each of the cells lies: found again from the forest, as it keeps it. */
void blast_centre(const blast_solver* s, size_t i, double centre[3]) {
  const p8est_connectivity_t* const c = s->connectivity;
  p4est_topidx_t t;
  for (t = 0; t < c->num_trees; ++t) {
    p8est_tree_t* const tree = p8est_tree_array_index(s->forest->trees, t);
    const size_t first = (size_t)tree->quadrants_offset;
    if (i >= first && i < first + tree->quadrants.elem_count) {
      const p8est_quadrant_t* const q = p8est_quadrant_array_index(&tree->quadrants, i - first);
      const p4est_qcoord_t at[3] = {q->x, q->y, q->z};
      const double half = 0.5 * P8EST_QUADRANT_LEN(q->level);
      const double* const corner = c->vertices + 3 * c->tree_to_vertex[8 * t];
      int a;
      for (a = 0; a < 3; ++a)
        centre[a] = s->config.tree_size * (corner[a] + (at[a] + half) / P8EST_ROOT_LEN);
      return;
    }
  }
}

/* One face of the list; half of it may be a wall. Without room, nothing: face_count says so. */
static void add_face(blast_solver* s, blast_cell* lower, blast_cell* upper, double size, int axis,
                     int quarter) {
  if (s->face_count < s->face_room) {
    blast_face* const f = s->faces + s->face_count;
    f->lower = lower;
    f->upper = upper;
    f->size = size;
    f->axis = axis;
    f->quarter = quarter;
  }
  ++s->face_count;
}

static double size_of(const blast_solver* s, const p8est_quadrant_t* q) {
  return s->config.tree_size * P8EST_QUADRANT_LEN(q->level) / P8EST_ROOT_LEN;
}

/* Null: neither here nor a ghost, so none of the cells here has this part of the face. */
static blast_cell* cell_at(blast_solver* s, const p8est_quadrant_t* q, int is_ghost,
                           p4est_locidx_t number) {
  return is_ghost ? (q ? s->ghost_cells + number : NULL) : cell_of(q);
}

static blast_cell* whole_cell(blast_solver* s, const p8est_iter_face_side_t* side) {
  return cell_at(s, side->is.full.quad, side->is.full.is_ghost, side->is.full.quadid);
}

/* The one at a quarter of the face. */
static blast_cell* cell_at_quarter(blast_solver* s, const p8est_iter_face_side_t* side, int i) {
  return side->is_hanging ? cell_at(s, side->is.hanging.quad[i], side->is.hanging.is_ghost[i],
                                    side->is.hanging.quadid[i])
                          : whole_cell(s, side);
}

static int is_here(const p8est_iter_face_side_t* side, int i) {
  return side->is_hanging ? !side->is.hanging.is_ghost[i] : !side->is.full.is_ghost;
}

static void visit_face(p8est_iter_face_info_t* info, void* user) {
  blast_solver* const s = user;
  p8est_iter_face_side_t* const first = p8est_iter_fside_array_index_int(&info->sides, 0);
  const int axis = first->face / 2;
  p8est_iter_face_side_t *lower = first, *upper = NULL;
  int i;
  if (info->sides.elem_count == 2)
    upper = p8est_iter_fside_array_index_int(&info->sides, 1);
  if (first->face % 2 == 0) { /* its lower side touches the face, so it is the upper one */
    lower = upper;
    upper = first;
  }
  if (!lower || !upper) {
    const p8est_quadrant_t* const q = first->is.full.quad;
    add_face(s, lower ? cell_of(q) : NULL, upper ? cell_of(q) : NULL, size_of(s, q), axis, -1);
  } else if (!lower->is_hanging && !upper->is_hanging) {
    add_face(s, whole_cell(s, lower), whole_cell(s, upper), size_of(s, lower->is.full.quad), axis,
             -1);
  } else {
    const p8est_iter_face_side_t* const fine = lower->is_hanging ? lower : upper;
    for (i = 0; i < P8EST_HALF; ++i)
      if (is_here(lower, i) || is_here(upper, i))
        add_face(s, cell_at_quarter(s, lower, i), cell_at_quarter(s, upper, i),
                 size_of(s, fine->is.hanging.quad[i]), axis, i);
  }
}

/* Of a checkerboard of cells of this level. */
static int color_of(const p8est_quadrant_t* q) {
  const int bits = P8EST_MAXLEVEL - q->level;
  return ((q->x >> bits) + (q->y >> bits) + (q->z >> bits)) & 1;
}

static void* enlarged(void* old, size_t count, size_t size, int* good) {
  void* const now = realloc(old, (count ? count : 1) * size);
  *good = *good && now;
  return now ? now : old;
}

/* Across corners too, so that of a face in quarters all cells are known. */
static int list_ghosts(blast_solver* s) {
  int good = 1;
  if (s->forest->mpisize == 1)
    return 1;
  if (s->ghost)
    p8est_ghost_destroy(s->ghost);
  s->ghost = p8est_ghost_new(s->forest, P8EST_CONNECT_FULL);
  s->ghost_cells =
      enlarged(s->ghost_cells, s->ghost->ghosts.elem_count, sizeof *s->ghost_cells, &good);
  s->mirrors = enlarged(s->mirrors, s->ghost->mirrors.elem_count, sizeof *s->mirrors, &good);
  return good;
}

int blast_list_cells(blast_solver* s) {
  const size_t n = (size_t)s->forest->local_num_quadrants;
  p4est_topidx_t t;
  size_t i, k = 0;
  int good = list_ghosts(s), pass;
  s->cells = enlarged(s->cells, n, sizeof *s->cells, &good);
  s->numbers = enlarged(s->numbers, n, sizeof *s->numbers, &good);
  s->work =
      enlarged(s->work, n + (s->ghost ? s->ghost->ghosts.elem_count : 0), sizeof *s->work, &good);
  if (!blast_all(s, good))
    return 0;
  for (t = 0; t < s->connectivity->num_trees; ++t) {
    p8est_tree_t* const tree = p8est_tree_array_index(s->forest->trees, t);
    for (i = 0; i < tree->quadrants.elem_count; ++i, ++k) {
      const p8est_quadrant_t* const q = p8est_quadrant_array_index(&tree->quadrants, i);
      s->cells[k] = cell_of(q);
      s->cells[k]->number = k;
      s->numbers[k] = s->forest->global_first_quadrant[s->forest->mpirank] + (int64_t)k;
      s->cells[k]->level = q->level;
      s->cells[k]->checkers = color_of(q);
      memset(s->work + k, 0, sizeof s->work[k]);
      s->work[k].size = size_of(s, q);
    }
  }
  blast_exchange_cells(s); /* faces ask for their numbers and levels */
  blast_exchange_work(s);
  for (pass = 0; good && pass < 2; ++pass) { /* the first may find too little room */
    s->face_count = 0;
    p8est_iterate(s->forest, s->ghost, s, NULL, visit_face, NULL, NULL);
    if (s->face_count <= s->face_room)
      break;
    s->faces = enlarged(s->faces, s->face_count, sizeof *s->faces, &good);
    if (good)
      s->face_room = s->face_count;
  }
  for (i = 0; good && i < s->face_count; ++i)
    if (s->faces[i].quarter >= 0)
      s->faces[i].lower->checkers = s->faces[i].upper->checkers = 2.0;
  return blast_all(s, good);
}

static double jump(double a, double b) {
  return fabs(a - b) / fmin(a, b);
}

/* What each cell wants: finer where there are jumps and around them, coarser far from any. */
static void mark(blast_solver* s) {
  const size_t n = (size_t)s->forest->local_num_quadrants;
  size_t i;
  int round;
  blast_exchange_cells(s);
  for (i = 0; i < n; ++i)
    s->cells[i]->jump = 0.0;
  for (i = 0; i < s->face_count; ++i) {
    const blast_face* const f = s->faces + i;
    if (f->lower && f->upper) {
      const double most = fmax(jump(f->lower->density, f->upper->density),
                               jump(f->lower->pressure, f->upper->pressure));
      f->lower->jump = fmax(f->lower->jump, most);
      f->upper->jump = fmax(f->upper->jump, most);
    }
  }
  for (i = 0; i < n; ++i) {
    blast_cell* const c = s->cells[i];
    c->wanted = c->jump > s->config.refine ? 1 : c->jump < s->config.coarsen ? -1 : 0;
  }
  for (round = 1; round <= s->config.margin; ++round) { /* 1 + round: marked in this round */
    blast_exchange_cells(s);
    for (i = 0; i < s->face_count; ++i) {
      const blast_face* const f = s->faces + i;
      if (!f->lower || !f->upper)
        continue;
      if (f->lower->wanted > 0 && f->lower->wanted <= round && f->upper->wanted <= 0)
        f->upper->wanted = 1 + round;
      if (f->upper->wanted > 0 && f->upper->wanted <= round && f->lower->wanted <= 0)
        f->lower->wanted = 1 + round;
    }
  }
}

static int is_refined(p8est_t* forest, p4est_topidx_t tree, p8est_quadrant_t* q) {
  const blast_solver* const s = forest->user_pointer;
  (void)tree;
  return q->level < s->config.finest && cell_of(q)->wanted > 0;
}

static int is_coarsened(p8est_t* forest, p4est_topidx_t tree, p8est_quadrant_t* family[]) {
  const blast_solver* const s = forest->user_pointer;
  int i;
  (void)tree;
  for (i = 0; i < P8EST_CHILDREN; ++i)
    if (family[i]->level <= s->config.coarsest || cell_of(family[i])->wanted >= 0)
      return 0;
  return 1;
}

/* Children have their parent's values, a parent the mean of its children's: nothing is lost. */
static void replace(p8est_t* forest, p4est_topidx_t tree, int old_count, p8est_quadrant_t* old[],
                    int new_count, p8est_quadrant_t* now[]) {
  int i, k;
  (void)forest;
  (void)tree;
  for (i = 0; i < new_count; ++i) {
    blast_cell* const c = cell_of(now[i]);
    *c = *cell_of(old[0]);
    c->wanted = 0;
    if (old_count == 1)
      continue;
    for (k = 0; k < GAS_VALUES; ++k) {
      double sum = 0.0;
      int j;
      for (j = 0; j < old_count; ++j)
        sum += cell_of(old[j])->u[k];
      c->u[k] = sum / old_count;
    }
  }
}

int blast_regrid(blast_solver* s) {
  const long revision = p8est_revision(s->forest);
  size_t i;
  mark(s);
  p8est_refine_ext(s->forest, 0, s->config.finest, is_refined, NULL, replace);
  p8est_coarsen_ext(s->forest, 0, 0, is_coarsened, NULL, replace);
  p8est_balance_ext(s->forest, P8EST_CONNECT_FULL, NULL, replace);
  p8est_partition(s->forest, 1, NULL); /* eight siblings stay together, to be coarsened */
  if (p8est_revision(s->forest) == revision)
    return 0;
  if (!blast_list_cells(s))
    return -1;
  for (i = 0; i < (size_t)s->forest->local_num_quadrants; ++i) {
    blast_cell* const c = s->cells[i];
    double w[GAS_VALUES];
    gas_primitive(c->u, s->config.gamma, w);
    c->density = w[0];
    memcpy(c->velocity, w + 1, sizeof c->velocity);
    c->pressure = w[4];
  }
  return 1;
}
