/* 14: an adaptive mesh of two dimensions. Leaves of quadtrees are refined towards a circle; a field
 * that is linear comes out exactly between the centres of leaves of any levels, at any height. */
#include <insitu/insitu.h>
#include <math.h>
#include <stdio.h>

enum { n = 4, most = n * n * 16 }; /* cells of the coarsest level along each axis; leaves */

static uint8_t level[most];
static int32_t corner[most][2]; /* in cells of the leaf's own level */
static double height[most];
static int64_t count = 0;

static const char scene[] =
    "insitu: 1\n"
    "page: false\n"
    "frames:\n"
    "  - {name: sheet, size: [300, 300], boundary: {color: {field: height}}}\n";

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

static double linear(double x, double y) {
  return 1 + x + 2 * y;
}

static void refine(int l, int32_t i, int32_t j) {
  const double h = 1.0 / (1 << l), x = (i + 0.5) * h, y = (j + 0.5) * h;
  if (l < 2 && fabs(hypot(x - 2, y - 2) - 1.2) < h) {
    for (int child = 0; child < 4; ++child)
      refine(l + 1, 2 * i + child % 2, 2 * j + child / 2);
    return;
  }
  level[count] = (uint8_t)l;
  corner[count][0] = i;
  corner[count][1] = j;
  height[count++] = linear(x, y);
}

int main(void) {
  for (int32_t j = 0; j < n; ++j)
    for (int32_t i = 0; i < n; ++i)
      refine(0, i, j);

  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  insitu_session_options options = insitu_session_options_default();
  insitu_amr amr = insitu_amr_default(); /* origin 0, spacing 1, ratio 2 */
  insitu_leaves leaves = insitu_leaves_default();
  const insitu_array heights = insitu_array_of(height, INSITU_FLOAT64, count, 1);
  options.scene_text = scene;
  options.output = "insitu_out/flat_adaptive";
  if (failed(insitu_session_open(&options, &session)) ||
      failed(insitu_session_mesh(session, "amr", &mesh)))
    return 1;
  amr.level_count = 3;
  amr.dimensions = 2;
  leaves.levels = insitu_array_of(level, INSITU_UINT8, count, 1);
  leaves.corners = insitu_array_of(corner, INSITU_INT32, count, 2);
  if (failed(insitu_mesh_amr(mesh, &amr)) || failed(insitu_mesh_leaves(mesh, 0, &leaves)) ||
      failed(insitu_mesh_field(mesh, 0, "height", INSITU_CELL, &heights, 1)) ||
      failed(insitu_mesh_commit(mesh, NULL)))
    return 1;

  const double points[2][3] = {{1.1, 2.7, 0}, {2.9, 0.6, 1000}};
  double error = 0;
  for (int p = 0; p < 2; ++p) {
    const double expected = linear(points[p][0], points[p][1]);
    double value;
    int32_t found;
    if (failed(insitu_mesh_sample_point(mesh, "height", points[p], &value, &found)))
      return 1;
    printf("height(%g, %g): %g\n", points[p][0], points[p][1], value);
    error = fmax(error, found ? fabs(value - expected) : 1);
  }
  if (failed(insitu_session_execute(session, 0, 0.0)) || failed(insitu_session_close(&session)))
    return 1;
  return !(error < 1e-13);
}
