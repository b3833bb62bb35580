/* 08: a p8est forest as a mesh. Its quadrants are read in place, and so are the records behind
 * them; a regrid is said by giving the forest again. Link insitu::p4est. */
#include <insitu/p4est.h>
#include <math.h>
#include <p8est_bits.h>
#include <p8est_extended.h>
#include <stddef.h>
#include <stdio.h>

typedef struct record {
  int material;
  double height; /* of the cell's centre */
} record;

static void fill(p8est_t* forest, p4est_topidx_t tree, p8est_quadrant_t* q) {
  record* const r = (record*)q->p.user_data;
  double corner[3];
  p8est_qcoord_to_vertex(forest->connectivity, tree, q->x, q->y, q->z, corner);
  r->material = 1;
  r->height = corner[2] + 0.5 * P8EST_QUADRANT_LEN(q->level) / P8EST_ROOT_LEN;
}

/* Finer towards the floor of the first tree. */
static int is_refined(p8est_t* forest, p4est_topidx_t tree, p8est_quadrant_t* q) {
  (void)forest;
  return tree == 0 && q->z == 0;
}

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s %s\n", insitu_status_name(status), insitu_p4est_message(),
            insitu_last_message());
  return status != INSITU_OK;
}

static int give(insitu_mesh mesh, p8est_t* forest) {
  return failed(insitu_p4est_mesh(mesh, forest, NULL, NULL)) ||
         failed(insitu_p4est_field(mesh, forest, "height", INSITU_FLOAT64, offsetof(record, height),
                                   1)) ||
         failed(insitu_mesh_commit(mesh, NULL));
}

static int run(p8est_t* forest) {
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  if (failed(insitu_session_open(NULL, &session)) ||
      failed(insitu_session_mesh(session, "forest", &mesh)) || give(mesh, forest))
    return 1;
  for (int regrid = 0; regrid < 3; ++regrid) {
    p8est_refine(forest, 0, is_refined, fill);
    p8est_balance(forest, P8EST_CONNECT_FULL, fill);
    if (give(mesh, forest))
      return 1;
  }
  const double point[3] = {1.05, 0.4, 0.45}; /* where fine and coarse cells meet */
  double value;
  int32_t found;
  if (failed(insitu_mesh_sample_point(mesh, "height", point, &value, &found)))
    return 1;
  printf("%ld cells, height(1.05, 0.4, 0.45): %g\n", (long)forest->local_num_quadrants, value);
  insitu_session_close(&session);
  return !(found && fabs(value - 0.45) < 1e-13);
}

int main(int argc, char** argv) {
  if (sc_MPI_Init(&argc, &argv) != sc_MPI_SUCCESS)
    return 1;
  p4est_init(NULL, SC_LP_ERROR);
  p8est_connectivity_t* const brick = p8est_connectivity_new_brick(2, 1, 1, 0, 0, 0);
  p8est_t* const forest =
      p8est_new_ext(sc_MPI_COMM_WORLD, brick, 0, 1, 1, sizeof(record), fill, NULL);
  const int status = run(forest);
  p8est_destroy(forest);
  p8est_connectivity_destroy(brick);
  sc_finalize();
  return sc_MPI_Finalize() == sc_MPI_SUCCESS ? status : 1;
}
