/* A solver that speaks Catalyst 2 and knows of no implementation: dye that a vortex stirs in a box,
 * on a structured grid whose arrays hold a layer of ghosts. Each step it describes its arrays, in
 * place, as a mesh of Blueprint's.
 *
 *   CATALYST_IMPLEMENTATION_NAME=insitu CATALYST_IMPLEMENTATION_PATHS=<libdir>/catalyst \
 *     example_catalyst examples/catalyst/scene.yaml
 *
 * The scene's name is all that it hands on. Exit code: 0, or 1 where a call of Catalyst failed. */
#include <catalyst.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum {
  NI = 32,
  NJ = 32,
  NK = 12, /* cells */
  MI = NI + 2,
  MJ = NJ + 2,
  MK = NK + 2,
  CELLS = MI * MJ * MK,
  VERTICES = (MI + 1) * (MJ + 1) * (MK + 1),
  STEPS = 60
};

typedef struct {
  double x[VERTICES], y[VERTICES], z[VERTICES];
  double u[VERTICES], v[VERTICES], w[VERTICES];
  double dye[CELLS], next[CELLS];
} Solver;

static int cell(int i, int j, int k) {
  return i + MI * (j + MJ * k);
}

static void start(Solver* s) {
  int i, j, k, n = 0;
  for (k = 0; k <= MK; ++k)
    for (j = 0; j <= MJ; ++j)
      for (i = 0; i <= MI; ++i, ++n) {
        s->x[n] = (i - 1) / (double)NI;
        s->y[n] = (j - 1) / (double)NJ;
        s->z[n] = (k - 1) / (double)NI;
      }
  for (k = 0, n = 0; k < MK; ++k)
    for (j = 0; j < MJ; ++j)
      for (i = 0; i < MI; ++i, ++n)
        s->dye[n] = hypot((i - 0.5) / NI - 0.5, (j - 0.5) / NJ - 0.75) < 0.15 ? 1.0 : 0.0;
}

/* A vortex whose walls nothing passes, which turns back and forth, and a slow rise in its middle.
 */
static void set_velocity(Solver* s, double time) {
  const double pi = 3.14159265358979323846;
  int n;
  for (n = 0; n < VERTICES; ++n) {
    const double x = s->x[n], y = s->y[n];
    s->u[n] = -sin(pi * x) * cos(pi * y) * cos(0.5 * time);
    s->v[n] = cos(pi * x) * sin(pi * y) * cos(0.5 * time);
    s->w[n] = 0.02 * sin(pi * x) * sin(pi * y);
  }
}

/* First order upwind, with the velocity of each cell's first vertex; ghosts are copies of their
 * neighbours. */
static void step(Solver* s, double dt) {
  int i, j, k;
  for (k = 1; k <= NK; ++k)
    for (j = 1; j <= NJ; ++j)
      for (i = 1; i <= NI; ++i) {
        const int c = cell(i, j, k), vertex = i + (MI + 1) * (j + (MJ + 1) * k);
        const double u = s->u[vertex], v = s->v[vertex];
        const double dx = u > 0 ? s->dye[c] - s->dye[c - 1] : s->dye[c + 1] - s->dye[c];
        const double dy = v > 0 ? s->dye[c] - s->dye[c - MI] : s->dye[c + MI] - s->dye[c];
        s->next[c] = s->dye[c] - dt * (u * dx * NI + v * dy * NJ);
      }
  for (k = 0; k < MK; ++k)
    for (j = 0; j < MJ; ++j)
      for (i = 0; i < MI; ++i)
        s->dye[cell(i, j, k)] = s->next[cell(i < 1    ? 1
                                             : i > NI ? NI
                                                      : i,
                                             j < 1    ? 1
                                             : j > NJ ? NJ
                                                      : j,
                                             k < 1    ? 1
                                             : k > NK ? NK
                                                      : k)];
}

/* The grid without its ghosts: offsets and strides within the arrays. */
static void describe(conduit_node* data, Solver* s) {
  int64_t from[3] = {1, 1, 1};
  int64_t of_vertices[3] = {1, MI + 1, (MI + 1) * (MJ + 1)}, of_cells[3] = {1, MI, MI * MJ};
  conduit_node_set_path_char8_str(data, "coordsets/coords/type", "explicit");
  conduit_node_set_path_external_float64_ptr(data, "coordsets/coords/values/x", s->x, VERTICES);
  conduit_node_set_path_external_float64_ptr(data, "coordsets/coords/values/y", s->y, VERTICES);
  conduit_node_set_path_external_float64_ptr(data, "coordsets/coords/values/z", s->z, VERTICES);
  conduit_node_set_path_char8_str(data, "topologies/grid/type", "structured");
  conduit_node_set_path_char8_str(data, "topologies/grid/coordset", "coords");
  conduit_node_set_path_int64(data, "topologies/grid/elements/dims/i", NI);
  conduit_node_set_path_int64(data, "topologies/grid/elements/dims/j", NJ);
  conduit_node_set_path_int64(data, "topologies/grid/elements/dims/k", NK);
  conduit_node_set_path_int64_ptr(data, "topologies/grid/elements/dims/offsets", from, 3);
  conduit_node_set_path_int64_ptr(data, "topologies/grid/elements/dims/strides", of_vertices, 3);
  conduit_node_set_path_char8_str(data, "fields/dye/association", "element");
  conduit_node_set_path_char8_str(data, "fields/dye/topology", "grid");
  conduit_node_set_path_external_float64_ptr(data, "fields/dye/values", s->dye, CELLS);
  conduit_node_set_path_int64_ptr(data, "fields/dye/offsets", from, 3);
  conduit_node_set_path_int64_ptr(data, "fields/dye/strides", of_cells, 3);
  conduit_node_set_path_char8_str(data, "fields/velocity/association", "vertex");
  conduit_node_set_path_char8_str(data, "fields/velocity/topology", "grid");
  conduit_node_set_path_external_float64_ptr(data, "fields/velocity/values/u", s->u, VERTICES);
  conduit_node_set_path_external_float64_ptr(data, "fields/velocity/values/v", s->v, VERTICES);
  conduit_node_set_path_external_float64_ptr(data, "fields/velocity/values/w", s->w, VERTICES);
  conduit_node_set_path_int64_ptr(data, "fields/velocity/offsets", from, 3);
  conduit_node_set_path_int64_ptr(data, "fields/velocity/strides", of_vertices, 3);
}

int main(int argc, char** argv) {
  const double dt = 0.02;
  Solver* solver = calloc(1, sizeof *solver);
  conduit_node* node = conduit_node_create();
  int n, failed = 0;
  if (!solver)
    return 1;
  start(solver);
  if (argc > 1)
    conduit_node_set_path_char8_str(node, "catalyst/scripts/scene/filename", argv[1]);
  conduit_node_set_path_char8_str(node, "catalyst/host", "vortex");
  failed = catalyst_initialize(node) != catalyst_status_ok;
  for (n = 0; !failed && n <= STEPS; ++n) {
    conduit_node* call = conduit_node_create();
    set_velocity(solver, n * dt);
    conduit_node_set_path_int64(call, "catalyst/state/timestep", n);
    conduit_node_set_path_float64(call, "catalyst/state/time", n * dt);
    conduit_node_set_path_char8_str(call, "catalyst/channels/grid/type", "mesh");
    describe(conduit_node_fetch(call, "catalyst/channels/grid/data"), solver);
    failed = catalyst_execute(call) != catalyst_status_ok;
    conduit_node_destroy(call);
    step(solver, dt);
  }
  failed |= catalyst_finalize(node) != catalyst_status_ok;
  conduit_node_destroy(node);
  free(solver);
  if (failed)
    fprintf(stderr, "example_catalyst: a call of Catalyst failed\n");
  return failed;
}
