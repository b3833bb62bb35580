/* 01: the smallest coupling. Hand over pointers once, execute once a step; the scene says what is
 * done: here, a probe that appends a row to insitu_out/point.csv at each cycle. */
#include <insitu/insitu.h>

#include <stdio.h>

static const char scene[] = "insitu: 1\n"
                            "output: insitu_out\n"
                            "probes:\n"
                            "  - {name: point, points: [[0.25, 0.5, 0.5]], fields: [pressure]}\n";

int main(void) {
  /* The solver's arrays: one hexahedron. */
  double x[8] = {0, 1, 1, 0, 0, 1, 1, 0}, y[8] = {0, 0, 1, 1, 0, 0, 1, 1},
         z[8] = {0, 0, 0, 0, 1, 1, 1, 1}, pressure[8] = {0};
  int32_t connectivity[8] = {0, 1, 2, 3, 4, 5, 6, 7};

  insitu_session_options options = insitu_session_options_default();
  options.scene_text = scene;
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  if (insitu_session_open(&options, &session) != INSITU_OK) {
    fprintf(stderr, "%s\n", insitu_last_message());
    return 1;
  }
  insitu_session_mesh(session, "hydro", &mesh);

  insitu_array points[3] = {insitu_array_of(x, INSITU_FLOAT64, 8, 1),
                            insitu_array_of(y, INSITU_FLOAT64, 8, 1),
                            insitu_array_of(z, INSITU_FLOAT64, 8, 1)};
  insitu_mesh_points(mesh, 0, points, 3);

  insitu_cells cells = insitu_cells_default();
  cells.shape = INSITU_HEXAHEDRON;
  cells.count = 1;
  cells.connectivity = insitu_array_of(connectivity, INSITU_INT32, 1, 8);
  insitu_mesh_cells(mesh, 0, &cells);

  insitu_array field = insitu_array_of(pressure, INSITU_FLOAT64, 8, 1);
  insitu_mesh_field(mesh, 0, "pressure", INSITU_VERTEX, &field, 1);

  int failures = 0;
  for (int cycle = 0; cycle < 5; ++cycle) {
    for (int v = 0; v < 8; ++v) /* the solver's step */
      pressure[v] = cycle + x[v];
    insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS);
    if (insitu_session_execute(session, cycle, 0.1 * cycle) != INSITU_OK) {
      fprintf(stderr, "cycle %d: %s\n", cycle, insitu_last_message()); /* and the solver goes on */
      ++failures;
    }
  }
  insitu_session_close(&session);
  printf("5 cycles, %d failed; see insitu_out/point.csv\n", failures);
  return failures;
}
