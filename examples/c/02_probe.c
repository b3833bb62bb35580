/* 02: the solver's own queries. No scene: commit, then locate and sample points at any time until
 * the arrays change. */
#include <insitu/insitu.h>

#include <math.h>
#include <stdio.h>

static int failed(insitu_status status) {
  if (status != INSITU_OK)
    fprintf(stderr, "%s: %s\n", insitu_status_name(status), insitu_last_message());
  return status != INSITU_OK;
}

int main(void) {
  /* Two tetrahedra; temperature 1 + 2x + 3y + 4z on vertices, a material number on cells. */
  const float xyz[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  const int32_t connectivity[2][4] = {{0, 1, 2, 3}, {1, 2, 3, 4}}; /* VTK's order */
  double temperature[5];
  const float material[2] = {7, 8};
  for (int v = 0; v < 5; ++v)
    temperature[v] = 1 + 2 * xyz[v][0] + 3 * xyz[v][1] + 4 * xyz[v][2];

  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  insitu_cells cells = insitu_cells_default();
  cells.shape = INSITU_TETRAHEDRON;
  cells.count = 2;
  cells.connectivity = insitu_array_of(connectivity, INSITU_INT32, 2, 4);
  const insitu_array points = insitu_array_of(xyz, INSITU_FLOAT32, 5, 3);
  const insitu_array on_vertices = insitu_array_of(temperature, INSITU_FLOAT64, 5, 1);
  const insitu_array on_cells = insitu_array_of(material, INSITU_FLOAT32, 2, 1);
  if (failed(insitu_session_open(NULL, &session)) ||
      failed(insitu_session_mesh(session, "solid", &mesh)) ||
      failed(insitu_mesh_points(mesh, 0, &points, 1)) ||
      failed(insitu_mesh_cells(mesh, 0, &cells)) ||
      failed(insitu_mesh_field(mesh, 0, "temperature", INSITU_VERTEX, &on_vertices, 1)) ||
      failed(insitu_mesh_field(mesh, 0, "material", INSITU_CELL, &on_cells, 1)) ||
      failed(insitu_mesh_commit(mesh, NULL)))
    return 1;

  /* Many points and several fields at once. */
  const double where[3][3] = {{0.1, 0.2, 0.3}, {0.6, 0.6, 0.5}, {2, 2, 2}};
  const insitu_array where_array = insitu_array_of(where, INSITU_FLOAT64, 3, 3);
  const char* const fields[2] = {"temperature", "material"};
  double t[3], m[3], *const values[2] = {t, m};
  int64_t cell[3];
  uint8_t found[3];
  insitu_sample_args args = insitu_sample_args_default();
  args.locate.points = &where_array;
  args.locate.cells = cell;
  args.locate.found = found;
  args.fields = fields;
  args.field_count = 2;
  args.values = values;
  if (failed(insitu_mesh_sample(mesh, &args)))
    return 1;
  int wrong = 0;
  for (int p = 0; p < 3; ++p) {
    printf("(%g, %g, %g): cell %d, temperature %g, material %g\n", where[p][0], where[p][1],
           where[p][2], (int)cell[p], t[p], m[p]);
    const double exact = 1 + 2 * where[p][0] + 3 * where[p][1] + 4 * where[p][2];
    wrong += found[p] ? !(fabs(t[p] - exact) < 1e-6) : !isnan(t[p]);
  }

  /* One point, one field. */
  double value;
  int32_t inside;
  if (failed(insitu_mesh_sample_point(mesh, "temperature", where[0], &value, &inside)))
    return 1;
  printf("alone: %g\n", value);
  wrong += !inside || value != t[0];
  return failed(insitu_session_close(&session)) || wrong;
}
