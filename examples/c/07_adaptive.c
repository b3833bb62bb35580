/* 07: an adaptive mesh of patches. A coarse patch with ghost layers and a fine one over a part of
 * it are read in place; a linear field comes out exactly between cell centres, across the levels
 * too, and, thanks to the ghosts, up to the domain's boundary. Leaves of octrees are given by
 * insitu_mesh_leaves, a p8est forest by insitu/p4est.h. */
#include <insitu/insitu.h>
#include <math.h>
#include <stdio.h>

enum { n = 4, g = 1 }; /* cells of a patch along each axis, ghost layers of the coarse one */

static double coarse[n + 2 * g][n + 2 * g][n + 2 * g]; /* [k][j][i], cells of edge 1 */
static double fine[n][n][n];                           /* cells of edge 1/2, over 1 to 3 */

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

static double linear(double x, double y, double z) {
  return 1 + x + 2 * y + 4 * z;
}

/* A patch of n cells along each axis from `lower` on, and its values, with ghosts around them. */
static int give(insitu_mesh mesh, int piece, int level, int lower, const double* values,
                int32_t ghosts) {
  const int64_t row = n + 2 * ghosts;
  insitu_patch patch = insitu_patch_default();
  insitu_array rho = insitu_array_default();
  patch.level = level;
  for (int a = 0; a < 3; ++a) {
    patch.lower[a] = lower;
    patch.cells[a] = rho.extent[a] = n;
    patch.ghosts_before[a] = patch.ghosts_after[a] = ghosts;
  }
  rho.data = values;
  rho.stride[1] = row * (int64_t)sizeof *values; /* stride[0]: packed */
  rho.stride[2] = row * rho.stride[1];
  return failed(insitu_mesh_patch(mesh, piece, &patch)) ||
         failed(insitu_mesh_field(mesh, piece, "rho", INSITU_CELL, &rho, 1));
}

int main(void) {
  for (int k = 0; k < n + 2 * g; ++k) /* ghosts, too, as boundary conditions fill them */
    for (int j = 0; j < n + 2 * g; ++j)
      for (int i = 0; i < n + 2 * g; ++i)
        coarse[k][j][i] = linear(i - g + 0.5, j - g + 0.5, k - g + 0.5);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        fine[k][j][i] = linear(1.25 + 0.5 * i, 1.25 + 0.5 * j, 1.25 + 0.5 * k);

  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  insitu_amr amr = insitu_amr_default(); /* origin 0, spacing 1, ratio 2 */
  amr.level_count = 2;
  if (failed(insitu_session_open(NULL, &session)) ||
      failed(insitu_session_mesh(session, "amr", &mesh)) || failed(insitu_mesh_amr(mesh, &amr)) ||
      give(mesh, 0, 0, 0, &coarse[g][g][g], g) || give(mesh, 1, 1, 2, &fine[0][0][0], 0) ||
      failed(insitu_mesh_commit(mesh, NULL)))
    return 1;

  /* Beside the fine patch, and in the domain's boundary. */
  const double points[2][3] = {{0.9, 2.2, 1.7}, {0, 2.2, 4}};
  double error = 0;
  for (int p = 0; p < 2; ++p) {
    const double* x = points[p];
    const double expected = linear(x[0], x[1], x[2]);
    double value;
    int32_t found;
    if (failed(insitu_mesh_sample_point(mesh, "rho", x, &value, &found)))
      return 1;
    printf("rho(%g, %g, %g): %g\n", x[0], x[1], x[2], value);
    error = fmax(error, found ? fabs(value - expected) : 1);
  }
  insitu_session_close(&session);
  return !(error < 1e-13);
}
