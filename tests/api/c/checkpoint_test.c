/* Checkpoint, restart and steps that are held, through the C API: tracks go on to the byte, two
 * checkpoints of the same state are the same file, and what does not fit is refused by name. Run in
 * a folder of its own. */
#include <insitu/insitu.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "expect.h"

static const char* const scene =
    "insitu: 1\npage: false\ntracers:\n"
    "  - {name: t, velocity: u, seeds: [[0.5, 0.5, 0.5], [0.25, 0.5, 0.75]],\n"
    "     time_interpolation: cubic, times: {interval: 0.03}, output: [csv, netcdf]}\n";

/* One cell, and a velocity that swings as a polynomial of the time. */
static double points[24] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
static const int64_t connectivity[8] = {0, 1, 2, 3, 4, 5, 6, 7};
static double velocity[24];

static insitu_session open_session(const char* output, insitu_mesh* mesh) {
  insitu_session session = NULL;
  insitu_session_options options = insitu_session_options_default();
  insitu_array a = insitu_array_of(points, INSITU_FLOAT64, 8, 3);
  insitu_cells cells = insitu_cells_default();
  options.scene_text = scene;
  options.output = output;
  EXPECT(insitu_session_open(&options, &session) == INSITU_OK);
  EXPECT(insitu_session_mesh(session, "m", mesh) == INSITU_OK);
  EXPECT(insitu_mesh_points(*mesh, 0, &a, 1) == INSITU_OK);
  cells.count = 1;
  cells.connectivity = insitu_array_of(connectivity, INSITU_INT64, 1, 8);
  EXPECT(insitu_mesh_cells(*mesh, 0, &cells) == INSITU_OK);
  a = insitu_array_of(velocity, INSITU_FLOAT64, 8, 3);
  EXPECT(insitu_mesh_field(*mesh, 0, "u", INSITU_VERTEX, &a, 1) == INSITU_OK);
  return session;
}

static void run(insitu_session session, insitu_mesh mesh, int first, int last) {
  int cycle, v;
  for (cycle = first; cycle <= last; ++cycle) {
    const double t = 0.1 * cycle;
    for (v = 0; v < 8; ++v) {
      velocity[3 * v] = 0.2 - t * t * points[3 * v + 1];
      velocity[3 * v + 1] = 0.1 * t * points[3 * v];
      velocity[3 * v + 2] = 0.3 * t * t * t - 0.1;
    }
    EXPECT(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS) == INSITU_OK);
    EXPECT(insitu_session_execute(session, cycle, t) == INSITU_OK);
  }
}

/* The whole file; the caller frees it. */
static char* content(const char* path, long* size) {
  FILE* file = fopen(path, "rb");
  char* bytes = NULL;
  *size = -1;
  EXPECT(file != NULL);
  if (!file)
    return NULL;
  fseek(file, 0, SEEK_END);
  *size = ftell(file);
  rewind(file);
  bytes = malloc((size_t)*size + 1);
  EXPECT(bytes && fread(bytes, 1, (size_t)*size, file) == (size_t)*size);
  fclose(file);
  return bytes;
}

static int same_files(const char* a, const char* b) {
  long m, n;
  char *x = content(a, &m), *y = content(b, &n);
  const int same = x && y && m == n && m > 100 && memcmp(x, y, (size_t)m) == 0;
  free(x);
  free(y);
  return same;
}

/* The values of steps that are held, after the solver's array has others. */
static void test_held(void) {
  const double origin[3] = {0, 0, 0};
  double value[3] = {0, 0, 0};
  int64_t held[2] = {-1, -1};
  int32_t count = 1;
  insitu_mesh mesh;
  insitu_session session = open_session("held", &mesh);
  EXPECT(insitu_session_hold(session, 2) == INSITU_OK);
  run(session, mesh, 8, 10);
  EXPECT(insitu_session_held(session, held, &count) == INSITU_OK);
  EXPECT(count == 2 && held[0] == 9 && held[1] == -1); /* there was room for one */
  EXPECT(insitu_session_show(session, 9) == INSITU_OK);
  EXPECT(insitu_mesh_sample_point(mesh, "u", origin, value, NULL) == INSITU_OK);
  EXPECT(value[2] > 0.1186 && value[2] < 0.1188); /* 0.3 * 0.9^3 - 0.1 */
  EXPECT_ERROR(insitu_session_show(session, 8), INSITU_ERROR_ARGUMENT, "those held are 9 10");
  EXPECT(insitu_session_show(session, INSITU_LIVE) == INSITU_OK);
  EXPECT(insitu_mesh_sample_point(mesh, "u", origin, value, NULL) == INSITU_OK);
  EXPECT(value[2] > 0.1999 && value[2] < 0.2001);
  EXPECT(insitu_session_close(&session) == INSITU_OK);
}

int main(void) {
  insitu_mesh mesh;
  insitu_session session;
  remove("whole/t.csv");
  remove("whole/t.nc");

  session = open_session("whole", &mesh);
  EXPECT_ERROR(insitu_session_checkpoint(session, "state"), INSITU_ERROR_ORDER, "state");
  run(session, mesh, 0, 4);
  EXPECT(insitu_session_checkpoint(session, "state") == INSITU_OK);
  EXPECT(insitu_session_checkpoint(session, "again") == INSITU_OK);
  const insitu_status recorded = insitu_session_record(session, "record.hdf");
  EXPECT(recorded == INSITU_OK || recorded == INSITU_ERROR_UNSUPPORTED); /* without HDF5 */
  EXPECT(same_files("state", "again"));
  EXPECT_ERROR(insitu_session_restart(session, "state"), INSITU_ERROR_ORDER, "restart");
  run(session, mesh, 5, 6);
  EXPECT(insitu_session_checkpoint(session, "after_6") == INSITU_OK);
  EXPECT(insitu_session_close(&session) == INSITU_OK);
  EXPECT(rename("whole/t.csv", "whole.csv") == 0);
  EXPECT(rename("whole/t.nc", "whole.nc") == 0);

  session = open_session("whole", &mesh); /* again, and beyond the checkpoint */
  run(session, mesh, 0, 5);
  EXPECT(insitu_session_close(&session) == INSITU_OK);
  session = open_session("whole", &mesh);
  EXPECT_ERROR(insitu_session_restart(session, "absent"), INSITU_ERROR_FILE, "absent");
  EXPECT_ERROR(insitu_session_restart(session, NULL), INSITU_ERROR_ARGUMENT, "null");
  EXPECT(insitu_session_close(&session) == INSITU_OK);
  session = open_session("whole", &mesh);
  EXPECT(insitu_session_restart(session, "state") == INSITU_OK);
  run(session, mesh, 5, 6);
  EXPECT(insitu_session_checkpoint(session, "after_restart") == INSITU_OK);
  EXPECT(insitu_session_close(&session) == INSITU_OK);
  EXPECT(same_files("after_6", "after_restart"));
  EXPECT(same_files("whole.csv", "whole/t.csv"));
  EXPECT(same_files("whole.nc", "whole/t.nc"));
  test_held();
  return failures;
}
