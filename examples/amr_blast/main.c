/* A blast in a brick on an adaptive grid, coupled: the solver moves its refined front every few
 * cycles, libinsitu reads p8est's quadrants and the records behind them in place. At the end: where
 * the time went, and how well mass and energy were kept. On several processes (mpirun -n 4
 * amr_blast ...) the first one alone prints. */
#include <insitu/p4est.h>
#include <stdio.h>
#include <stdlib.h>

#include "options.h"

/* hydro: what the gas does, continuous between cells; grid: the cells themselves, or null. */
typedef struct meshes {
  insitu_mesh hydro, grid;
} meshes;

static int is_root = 1; /* who prints, of several processes */

/* The numbers of cells among those of all processes, of each tree's cells in their order. */
static insitu_status give_numbers(insitu_mesh mesh, const blast_solver* blast) {
  const p8est_t* const f = blast->forest;
  const p4est_topidx_t first = f->first_local_tree;
  insitu_status status = INSITU_OK;
  p4est_topidx_t t;
  for (t = first; first >= 0 && t <= f->last_local_tree && status == INSITU_OK; ++t) {
    const p8est_tree_t* const tree = p8est_tree_array_index(f->trees, t);
    const insitu_array numbers =
        insitu_array_of(blast->numbers + tree->quadrants_offset, INSITU_INT64,
                        (int64_t)tree->quadrants.elem_count, 1);
    status = insitu_mesh_global_ids(mesh, t - first, INSITU_CELL, &numbers);
  }
  if (status != INSITU_OK)
    fprintf(stderr, "amr_blast: %s\n", insitu_last_message());
  return status;
}

/* The coupling: the forest, and what of each record is a field. Again after every regrid. */
static insitu_status couple(meshes to, blast_solver* blast) {
  static const struct {
    const char* name;
    size_t offset;
    int components;
  } fields[] = {{"density", offsetof(blast_cell, density), 1},
                {"pressure", offsetof(blast_cell, pressure), 1},
                {"velocity", offsetof(blast_cell, velocity), 3},
                {"level", offsetof(blast_cell, level), 1}};
  const double size = blast->config.tree_size;
  const double origin[3] = {0.0, 0.0, 0.0}, tree_size[3] = {size, size, size};
  insitu_status status = insitu_p4est_mesh(to.hydro, blast->forest, origin, tree_size);
  size_t i;
  for (i = 0; status == INSITU_OK && i < sizeof fields / sizeof *fields; ++i)
    status = insitu_p4est_field(to.hydro, blast->forest, fields[i].name, INSITU_FLOAT64,
                                fields[i].offset, fields[i].components);
  if (status == INSITU_OK && to.grid)
    status = insitu_p4est_mesh_as(to.grid, blast->forest, origin, tree_size, INSITU_NEAREST);
  if (status == INSITU_OK && to.grid)
    status = insitu_p4est_field(to.grid, blast->forest, "checkers", INSITU_FLOAT64,
                                offsetof(blast_cell, checkers), 1);
  if (status != INSITU_OK) {
    fprintf(stderr, "amr_blast: %s: %s\n", insitu_status_name(status), insitu_p4est_message());
    return status;
  }
  status = give_numbers(to.hydro, blast);
  return status == INSITU_OK && to.grid ? give_numbers(to.grid, blast) : status;
}

/* Says what failed, once for each status; the run goes on without it. */
static void report_failure(insitu_status status) {
  static insitu_status last = INSITU_OK;
  if (is_root && status != INSITU_OK && status != last)
    fprintf(stderr, "amr_blast: %s: %s\n", insitu_status_name(status), insitu_last_message());
  last = status;
}

static insitu_session open_session(const options* o, sc_MPI_Comm* communicator, meshes* to) {
  insitu_session session = NULL;
  insitu_session_options how = insitu_session_options_default();
  insitu_status status;
  how.scene = o->scene;
  how.output = o->output;
  how.threads = o->library_threads;
  how.communicator = communicator;
  status = insitu_session_open(&how, &session);
  if (status == INSITU_OK)
    status = insitu_session_mesh(session, "hydro", &to->hydro);
  if (status == INSITU_OK && o->checkers)
    status = insitu_session_mesh(session, "grid", &to->grid);
  report_failure(status);
  return session;
}

static double library_seconds(const insitu_report* r) {
  return r->commit_s + r->query_s + r->advect_s + r->render_s + r->output_s;
}

static void print_summary(insitu_session session, double solver_s, const char* output) {
  insitu_report r = insitu_report_default();
  char path[4096];
  if (insitu_session_report(session, &r) != INSITU_OK)
    return;
  printf("library %.2f s of %.2f s: commit %.2f, query %.2f, advect %.2f, render %.2f, output %.2f "
         "s\n",
         library_seconds(&r), library_seconds(&r) + solver_s, r.commit_s, r.query_s, r.advect_s,
         r.render_s, r.output_s);
  printf("bytes: %.1f MB of the solver's read in place, %.1f MB held (%.1f MB at the peak)\n",
         1e-6 * (double)r.bytes_borrowed, 1e-6 * (double)r.bytes_held, 1e-6 * (double)r.bytes_peak);
  printf("commits: %lld kept, %lld refitted, %lld rebuilt\n", (long long)r.keeps,
         (long long)r.refits, (long long)r.rebuilds);
  printf("%lld frames, %lld probe rows, %lld particles, %lld files, %lld failures\n",
         (long long)r.frames, (long long)r.probe_rows, (long long)r.particles_seeded,
         (long long)r.files, (long long)r.failures);
  if (output && snprintf(path, sizeof path, "%s/summary.json", output) < (int)sizeof path)
    report_failure(insitu_session_write_summary(session, path, solver_s));
}

/* One cycle, regridded if it is due; 0 if the solver cannot go on. */
static int advance(const options* o, blast_solver* blast, meshes to, long* regrids,
                   double* solver_s) {
  const double begin = sc_MPI_Wtime();
  int moved = 0;
  if (blast_step(blast, o->end - blast->time) < 0.0) {
    if (is_root)
      fprintf(stderr, "amr_blast: cycle %ld: density or pressure is not positive\n", blast->cycle);
    return 0;
  }
  if (blast->cycle % o->regrid == 0)
    moved = blast_regrid(blast);
  if (moved < 0) {
    if (is_root)
      fprintf(stderr, "amr_blast: no memory for the grid\n");
    return 0;
  }
  *solver_s += sc_MPI_Wtime() - begin;
  *regrids += moved;
  return blast_all(blast,
                   (moved ? couple(to, blast)
                          : insitu_mesh_changed(to.hydro, INSITU_CHANGED_FIELDS)) == INSITU_OK);
}

static int run(const options* o) {
  sc_MPI_Comm world = sc_MPI_COMM_WORLD;
  blast_solver* const blast = blast_new(&o->config, world);
  const int is_alone = !blast || blast->forest->mpisize == 1;
  meshes to = {NULL, NULL};
  insitu_session session = open_session(o, is_alone ? NULL : &world, &to);
  double before[GAS_VALUES], now[GAS_VALUES], solver_s = 0.0;
  long regrids = 0;
  int good = blast && blast_all(blast, to.hydro && couple(to, blast) == INSITU_OK);
  if (!blast && is_root)
    fprintf(stderr, "amr_blast: no memory, or a grid of no sense\n");
  if (good) {
    blast_totals(blast, before);
    report_failure(insitu_session_execute(session, 0, 0.0));
    if (!o->quiet)
      printf("%6s %11s %9s %9s %9s\n", "cycle", "time", "cells", "mass", "energy");
  }
  while (good && blast->time < o->end && blast->cycle < o->cycles) {
    good = advance(o, blast, to, &regrids, &solver_s);
    if (!good)
      break;
    report_failure(insitu_session_execute(session, blast->cycle, blast->time));
    if (o->quiet)
      continue;
    blast_totals(blast, now);
    printf("%6ld %11.5e %9ld %9.1e %9.1e\n", blast->cycle, blast->time,
           (long)blast->forest->global_num_quadrants, now[0] / before[0] - 1.0,
           now[4] / before[4] - 1.0);
  }
  if (good) {
    blast_totals(blast, now);
    printf("%ld cycles, %ld regrids, %ld cells of levels up to %d, %.2f s in the solver\n",
           blast->cycle, regrids, (long)blast->forest->global_num_quadrants, o->config.finest,
           solver_s);
    printf("drift of mass %.1e, of energy %.1e\n", now[0] / before[0] - 1.0,
           now[4] / before[4] - 1.0);
    print_summary(session, solver_s, o->output);
  }
  report_failure(insitu_session_close(&session));
  blast_free(blast);
  return good ? EXIT_SUCCESS : EXIT_FAILURE;
}

int main(int argc, char** argv) {
  options o;
  int rank = 0, level = 0, status = parse_options(argc, argv, &o);
  if (status >= 0)
    return status;
  if (sc_MPI_Init_thread(&argc, &argv, sc_MPI_THREAD_FUNNELED, &level) != sc_MPI_SUCCESS)
    return EXIT_FAILURE;
  sc_MPI_Comm_rank(sc_MPI_COMM_WORLD, &rank);
  is_root = rank == 0;
  if (!is_root && !freopen("/dev/null", "w", stdout))
    return EXIT_FAILURE;
  p4est_init(NULL, SC_LP_ERROR);
  status = run(&o);
  sc_finalize();
  return sc_MPI_Finalize() == sc_MPI_SUCCESS ? status : EXIT_FAILURE;
}
