#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "insitu/p4est.h"

static __thread char message[1024];

static insitu_status refuse(insitu_status status, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);
  return status;
}

/* A call of the library, whose message is kept. */
static insitu_status passed(insitu_status status) {
  if (status != INSITU_OK)
    snprintf(message, sizeof message, "%s", insitu_last_message());
  return status;
}

const char* insitu_p4est_message(void) {
  return message;
}

/* Trees that are equal boxes: the first corner of all, and the lengths of one. */
typedef struct brick {
  double lower[3], size[3];
} brick;

static const double* corner_of(const p8est_connectivity_t* c, p4est_topidx_t tree, int corner) {
  return c->vertices + 3 * c->tree_to_vertex[8 * tree + corner];
}

/* Vertices are computed by whoever made them, so they may be off by roundings. */
static int is_near(double a, double b, double size) {
  return fabs(a - b) <= 1e-9 * size;
}

static insitu_status find_brick(const p8est_connectivity_t* c, brick* out) {
  int a;
  p4est_topidx_t tree;
  if (!c->vertices || !c->tree_to_vertex || c->num_trees < 1)
    return refuse(INSITU_ERROR_ARGUMENT,
                  "forest: its connectivity has no vertices, from which trees are placed");
  for (a = 0; a < 3; ++a) {
    out->lower[a] = corner_of(c, 0, 0)[a];
    out->size[a] = corner_of(c, 0, 7)[a] - out->lower[a];
    if (!(out->size[a] > 0.0))
      return refuse(INSITU_ERROR_UNSUPPORTED,
                    "forest: tree 0 is %g long along axis %d; only bricks, trees that are equal "
                    "boxes along the axes, are supported",
                    out->size[a], a);
    for (tree = 1; tree < c->num_trees; ++tree)
      out->lower[a] = fmin(out->lower[a], corner_of(c, tree, 0)[a]);
  }
  return INSITU_OK;
}

/* Where a tree lies, counted in trees from the brick's lower corner. */
typedef struct place {
  int64_t at[3];
  p4est_topidx_t tree;
} place;

static insitu_status find_place(const p8est_connectivity_t* c, p4est_topidx_t tree, const brick* b,
                                place* out) {
  int a, corner;
  out->tree = tree;
  for (a = 0; a < 3; ++a)
    out->at[a] = llround((corner_of(c, tree, 0)[a] - b->lower[a]) / b->size[a]);
  for (corner = 0; corner < 8; ++corner)
    for (a = 0; a < 3; ++a) {
      const double found = corner_of(c, tree, corner)[a];
      const double expected = b->lower[a] + (double)(out->at[a] + (corner >> a & 1)) * b->size[a];
      if (!is_near(found, expected, b->size[a]))
        return refuse(INSITU_ERROR_UNSUPPORTED,
                      "forest: corner %d of tree %ld is at %g along axis %d, %g expected; only "
                      "bricks, trees that are equal boxes along the axes, are supported",
                      corner, (long)tree, found, a, expected);
    }
  return INSITU_OK;
}

static int by_place(const void* left, const void* right) {
  const int64_t* const l = ((const place*)left)->at;
  const int64_t* const r = ((const place*)right)->at;
  int a;
  for (a = 2; a > 0 && l[a] == r[a]; --a) {
  }
  return (l[a] > r[a]) - (l[a] < r[a]);
}

/* Connectivities made for a geometry that bends trees may have all of them at one place. */
static insitu_status expect_no_overlap(const place* places, p4est_topidx_t count) {
  const size_t bytes = (size_t)count * sizeof *places;
  place* const sorted = malloc(bytes);
  insitu_status status = INSITU_OK;
  p4est_topidx_t i;
  if (!sorted)
    return refuse(INSITU_ERROR_MEMORY, "forest: no memory for the places of %ld trees",
                  (long)count);
  memcpy(sorted, places, bytes);
  qsort(sorted, (size_t)count, sizeof *sorted, by_place);
  for (i = 1; status == INSITU_OK && i < count; ++i)
    if (by_place(sorted + i - 1, sorted + i) == 0)
      status = refuse(INSITU_ERROR_UNSUPPORTED,
                      "forest: trees %ld and %ld lie at one place; only bricks, trees that are "
                      "equal boxes along the axes, are supported",
                      (long)sorted[i - 1].tree, (long)sorted[i].tree);
  free(sorted);
  return status;
}

/* The places of all trees, so that every process refuses the same forest. */
static insitu_status find_places(const p8est_connectivity_t* c, const brick* b, place* places) {
  insitu_status status = INSITU_OK;
  p4est_topidx_t t;
  for (t = 0; status == INSITU_OK && t < c->num_trees; ++t)
    status = find_place(c, t, b, places + t);
  return status == INSITU_OK ? expect_no_overlap(places, c->num_trees) : status;
}

/* Numbers of this process's trees: first to first + count - 1. */
static void local_trees(const p8est_t* forest, p4est_topidx_t* first, p4est_topidx_t* count) {
  *first = forest->first_local_tree < 0 ? 0 : forest->first_local_tree;
  *count = forest->first_local_tree < 0 ? 0 : forest->last_local_tree - *first + 1;
}

static p8est_tree_t* tree_of(const p8est_t* forest, p4est_topidx_t tree) {
  return (p8est_tree_t*)sc_array_index(forest->trees, (size_t)tree);
}

static insitu_array array_of(const sc_array_t* quadrants, size_t offset, insitu_type type,
                             int32_t components) {
  const size_t n = quadrants ? quadrants->elem_count : 0;
  insitu_array a =
      insitu_array_of(n ? quadrants->array + offset : NULL, type, (int64_t)n, components);
  a.stride[0] = (int64_t)sizeof(p8est_quadrant_t);
  return a;
}

static insitu_status give_leaves(insitu_mesh mesh, int32_t piece, const sc_array_t* quadrants,
                                 const int64_t at[3]) {
  int a;
  insitu_leaves leaves = insitu_leaves_default();
  leaves.levels = array_of(quadrants, offsetof(p8est_quadrant_t, level), INSITU_UINT8, 1);
  leaves.corners = array_of(quadrants, offsetof(p8est_quadrant_t, x), INSITU_INT32, 3);
  leaves.corner_bits = P8EST_MAXLEVEL;
  for (a = 0; a < 3; ++a)
    leaves.offset[a] = at[a] * P8EST_ROOT_LEN;
  return passed(insitu_mesh_leaves(mesh, piece, &leaves));
}

static insitu_status give_levels(insitu_mesh mesh, const p8est_t* forest, const brick* b,
                                 const double* origin, const double* tree_size,
                                 insitu_reconstruction reconstruction) {
  insitu_amr amr = insitu_amr_default();
  p4est_topidx_t first, count, t;
  int a;
  amr.reconstruction = reconstruction;
  local_trees(forest, &first, &count);
  for (t = first; t < first + count; ++t)
    if (tree_of(forest, t)->maxlevel >= amr.level_count)
      amr.level_count = tree_of(forest, t)->maxlevel + 1;
  for (a = 0; a < 3; ++a) {
    amr.origin[a] = origin ? origin[a] : b->lower[a];
    amr.spacing[a] = tree_size ? tree_size[a] : b->size[a];
  }
  return passed(insitu_mesh_amr(mesh, &amr));
}

/* The pieces: one a local tree, at least one. */
static insitu_status give_pieces(insitu_mesh mesh, const p8est_t* forest, const place* places) {
  p4est_topidx_t first, count, t;
  insitu_status status = INSITU_OK;
  local_trees(forest, &first, &count);
  if (count == 0)
    status = give_leaves(mesh, 0, NULL, places[0].at);
  for (t = first; status == INSITU_OK && t < first + count; ++t)
    status = give_leaves(mesh, t - first, &tree_of(forest, t)->quadrants, places[t].at);
  if (status == INSITU_OK) /* after a partition there may be fewer trees here */
    status = passed(insitu_mesh_drop_pieces(mesh, count ? count : 1));
  return status;
}

insitu_status insitu_p4est_mesh(insitu_mesh mesh, p8est_t* forest, const double origin[3],
                                const double tree_size[3]) {
  return insitu_p4est_mesh_as(mesh, forest, origin, tree_size, INSITU_DUAL);
}

insitu_status insitu_p4est_mesh_as(insitu_mesh mesh, p8est_t* forest, const double origin[3],
                                   const double tree_size[3],
                                   insitu_reconstruction reconstruction) {
  brick b;
  place* places;
  insitu_status status;
  message[0] = '\0';
  if (!forest)
    return refuse(INSITU_ERROR_ARGUMENT, "forest: null");
  if (!origin != !tree_size)
    return refuse(INSITU_ERROR_ARGUMENT,
                  "origin and tree_size: one of them is null; both or none expected");
  status = find_brick(forest->connectivity, &b);
  if (status != INSITU_OK)
    return status;
  places = malloc((size_t)forest->connectivity->num_trees * sizeof *places);
  if (!places)
    return refuse(INSITU_ERROR_MEMORY, "forest: no memory for the places of its trees");
  status = find_places(forest->connectivity, &b, places);
  if (status == INSITU_OK)
    status = give_levels(mesh, forest, &b, origin, tree_size, reconstruction);
  if (status == INSITU_OK)
    status = give_pieces(mesh, forest, places);
  free(places);
  return status;
}

/* A field of other quadrants than those that are the mesh's leaves means a regrid that the mesh was
 * not told of; the leaves' arrays may be freed. */
static insitu_status expect_same_quadrants(insitu_mesh mesh, const char* name,
                                           const p8est_t* forest) {
  p4est_topidx_t first, count, t;
  int32_t n = 0, room, i;
  insitu_status status = passed(insitu_mesh_audit(mesh, NULL, &n));
  insitu_audit_entry* const entries =
      status == INSITU_OK && n > 0 ? malloc((size_t)n * sizeof *entries) : NULL;
  if (status != INSITU_OK || n == 0)
    return status;
  if (!entries)
    return refuse(INSITU_ERROR_MEMORY, "field '%s': no memory for the mesh's arrays", name);
  room = n;
  status = passed(insitu_mesh_audit(mesh, entries, &room));
  local_trees(forest, &first, &count);
  for (i = 0; status == INSITU_OK && i < n; ++i) {
    static const char piece[] = "piece ", levels[] = " levels";
    char* rest;
    const sc_array_t* quadrants;
    insitu_array now;
    if (strncmp(entries[i].name, piece, sizeof piece - 1) != 0)
      continue;
    t = (p4est_topidx_t)strtol(entries[i].name + sizeof piece - 1, &rest, 10);
    if (strcmp(rest, levels) != 0)
      continue;
    quadrants = t < count ? &tree_of(forest, first + t)->quadrants : NULL;
    now = array_of(quadrants, offsetof(p8est_quadrant_t, level), INSITU_UINT8, 1);
    if (now.data != entries[i].data || now.count != entries[i].bytes)
      status = refuse(INSITU_ERROR_ORDER,
                      "field '%s': tree %ld has %ld quadrants at %p, but the mesh's piece %ld was "
                      "given %ld at %p; after a regrid call insitu_p4est_mesh first",
                      name, (long)(first + t), (long)now.count, now.data, (long)t,
                      (long)entries[i].bytes, entries[i].data);
  }
  free(entries);
  return status;
}

insitu_status insitu_p4est_field(insitu_mesh mesh, p8est_t* forest, const char* name,
                                 insitu_type type, size_t offset, int32_t components) {
  p4est_topidx_t first, count, t;
  insitu_status status = INSITU_OK;
  size_t bytes;
  message[0] = '\0';
  if (!forest)
    return refuse(INSITU_ERROR_ARGUMENT, "forest: null");
  if (type != INSITU_FLOAT32 && type != INSITU_FLOAT64)
    return refuse(INSITU_ERROR_ARGUMENT, "field '%s': type %d, float32 or float64 expected",
                  name ? name : "", (int)type);
  bytes = (type == INSITU_FLOAT32 ? 4u : 8u) * (size_t)(components < 0 ? 0 : components);
  if (forest->data_size == 0 || offset > forest->data_size || bytes > forest->data_size - offset)
    return refuse(INSITU_ERROR_ARGUMENT,
                  "field '%s': bytes %lu to %lu of each quadrant's record, which has %lu",
                  name ? name : "", (unsigned long)offset, (unsigned long)(offset + bytes),
                  (unsigned long)forest->data_size);
  status = expect_same_quadrants(mesh, name ? name : "", forest);
  local_trees(forest, &first, &count);
  for (t = 0; status == INSITU_OK && (t < count || t == 0); ++t) {
    const sc_array_t* quadrants = t < count ? &tree_of(forest, first + t)->quadrants : NULL;
    insitu_array values = array_of(quadrants, offsetof(p8est_quadrant_t, p), type, components);
    values.indirect = 1;
    values.offset = (int64_t)offset;
    status = passed(insitu_mesh_field(mesh, t, name, INSITU_CELL, &values, 1));
  }
  return status;
}
