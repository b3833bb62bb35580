/* 16: a gauge outside the mesh, and records. A probe with `outside: nearest` answers for a point
 * that no cell holds, and its table tells how far away the cell is. `record:` keeps what the solver
 * gave at each step, so that the same tables, or those of another scene, are made later without it:
 *
 *   cd insitu_out/nearest_and_record
 *   insitu-replay --check record.hdf.series            # what is in it, and what would be written
 *   insitu-replay --out again record.hdf.series        # again/gauges.csv is gauges.csv
 */
#include <insitu/insitu.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { n = 5, vertex_count = n * n * n }; /* a block of 4 x 4 x 4 cells, 1 along each side */

static const char with_record[] = "insitu: 1\n"
                                  "page: false\n"
                                  "record: {every: 1}\n"
                                  "probes:\n"
                                  "  - name: gauges\n"
                                  "    points: [[0.5, 0.5, 0.5], [1.2, 0.5, 0.5], [3, 3, 3]]\n"
                                  "    fields: [level]\n"
                                  "    outside: nearest\n"
                                  "    greatest_distance: 0.5\n";

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

int main(void) {
  static double level[vertex_count];
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  insitu_session_options options = insitu_session_options_default();
  options.scene_text = with_record;
  options.output = "insitu_out/nearest_and_record";
  insitu_status status = insitu_session_open(&options, &session);
  if (status == INSITU_ERROR_UNSUPPORTED) { /* a library that was built without HDF5 */
    printf("no records: %s\n", insitu_last_message());
    static char without[sizeof with_record];
    const char* const record = strstr(with_record, "record:");
    memcpy(without, with_record, (size_t)(record - with_record));
    strcat(without, strchr(record, '\n') + 1);
    options.scene_text = without;
    status = insitu_session_open(&options, &session);
  }
  insitu_block block = insitu_block_default();
  block.kind = INSITU_BLOCK_UNIFORM;
  for (int a = 0; a < 3; ++a) {
    block.vertices[a] = n;
    block.spacing[a] = 1.0 / (n - 1);
  }
  const insitu_array levels = insitu_array_of(level, INSITU_FLOAT64, vertex_count, 1);
  if (failed(status) || failed(insitu_session_mesh(session, "sea", &mesh)) ||
      failed(insitu_mesh_block(mesh, 0, &block)) ||
      failed(insitu_mesh_field(mesh, 0, "level", INSITU_VERTEX, &levels, 1)))
    return 1;
  for (int step = 0; step < 3; ++step) {
    for (int v = 0; v < vertex_count; ++v)
      level[v] = 10 * step + 0.25 * (v % n); /* 10 t + x */
    if (failed(insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS)) ||
        failed(insitu_session_execute(session, step, step)))
      return 1;
  }
  if (failed(insitu_session_close(&session)))
    return 1;

  /* The table: the middle, 0.2 beyond the side at x = 1, and a point that is too far from all. */
  FILE* const table = fopen("insitu_out/nearest_and_record/gauges.csv", "r");
  char line[200];
  printf("gauges.csv: point 0 is inside, point 1 is 0.2 outside, point 2 is too far away\n");
  int rows = 0, beyond = 0;
  while (table && fgets(line, sizeof line, table)) {
    fputs(line, stdout);
    double time, value, distance;
    int cycle, point, cell;
    if (sscanf(line, "%d,%lf,%d,%d,%*f,%*f,%*f,%lf,%lf", &cycle, &time, &point, &cell, &value,
               &distance) == 6 &&
        point == 1) /* the value at (1, 0.5, 0.5) */
      beyond += fabs(value - (10 * cycle + 1)) < 1e-12 && fabs(distance - 0.2) < 1e-12;
    ++rows;
  }
  if (table)
    fclose(table);
  return !(rows == 10 && beyond == 3);
}
