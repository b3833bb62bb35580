/* 03: structured blocks. A solver with ghost layers around its (i, j, k) arrays hands over the inner
 * part in place: where it starts, how long it is, and the strides. No connectivity, no copy. */
#include <insitu/insitu.h>

#include <math.h>
#include <stdio.h>

enum { ni = 6, nj = 5, nk = 4, g = 2 }; /* cells along each axis, ghost layers */

/* C order: k runs fastest, as many C codes have it. */
static double rho[ni + 2 * g][nj + 2 * g][nk + 2 * g];
static double xyz[ni + 1][nj + 1][nk + 1][3];

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

int main(void) {
  for (int i = 0; i < ni + 2 * g; ++i)
    for (int j = 0; j < nj + 2 * g; ++j)
      for (int k = 0; k < nk + 2 * g; ++k)
        rho[i][j][k] = 100 * (i - g) + 10 * (j - g) + (k - g);
  for (int i = 0; i <= ni; ++i)
    for (int j = 0; j <= nj; ++j)
      for (int k = 0; k <= nk; ++k) { /* a sheared, curved block */
        xyz[i][j][k][0] = i + 0.1 * j;
        xyz[i][j][k][1] = j;
        xyz[i][j][k][2] = k + 0.05 * sin(i);
      }

  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  insitu_block block = insitu_block_default(); /* curvilinear unless said */
  block.vertices[0] = ni + 1;
  block.vertices[1] = nj + 1;
  block.vertices[2] = nk + 1;

  insitu_array points = insitu_array_default();
  points.data = xyz;
  points.components = 3;
  points.extent[0] = ni + 1;
  points.extent[1] = nj + 1;
  points.extent[2] = nk + 1;
  points.stride[0] = sizeof xyz[0];
  points.stride[1] = sizeof xyz[0][0];
  points.stride[2] = sizeof xyz[0][0][0];

  insitu_array density = insitu_array_default();
  density.data = &rho[g][g][g]; /* the first inner cell */
  density.extent[0] = ni;
  density.extent[1] = nj;
  density.extent[2] = nk;
  density.stride[0] = sizeof rho[0];
  density.stride[1] = sizeof rho[0][0];
  density.stride[2] = sizeof rho[0][0][0];

  if (failed(insitu_session_open(NULL, &session)) ||
      failed(insitu_session_mesh(session, "block", &mesh)) ||
      failed(insitu_mesh_block(mesh, 0, &block)) ||
      failed(insitu_mesh_points(mesh, 0, &points, 1)) ||
      failed(insitu_mesh_field(mesh, 0, "density", INSITU_CELL, &density, 1)) ||
      failed(insitu_mesh_commit(mesh, NULL)))
    return 1;

  const double middle_of_4_2_1[3] = {4.5 + 0.1 * 2.5, 2.5, 1.5 + 0.025 * (sin(4) + sin(5))};
  double value;
  int32_t found;
  if (failed(insitu_mesh_sample_point(mesh, "density", middle_of_4_2_1, &value, &found)))
    return 1;
  printf("density of cell (4, 2, 1): %g\n", value);
  insitu_session_close(&session);
  return !(found && value == 421.0);
}
