/* One call of insitu_mesh_sample on unstructured hexahedra, whose files walk.sh lists. */
#include <insitu/insitu.h>
#include <stdio.h>
#include <stdlib.h>
enum { n = 12, v = n + 1, count = 2000 };
static double x[3 * v * v * v], f[v * v * v], p[3 * count], out[count];
static int64_t ids[8 * n * n * n];
int main(void) {
  int q = 0;
  for (int k = 0; k < v; ++k)
    for (int j = 0; j < v; ++j)
      for (int i = 0; i < v; ++i, ++q) {
        const int inner = i > 0 && i < n;
        x[3 * q] = i + 0.1 * inner * ((i * 7 + j * 3 + k * 5) % 3 - 1);
        x[3 * q + 1] = j; x[3 * q + 2] = k; f[q] = i + 2.0 * j;
      }
  q = 0;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i, ++q) {
        const int64_t b = i + v * (j + (int64_t)v * k), dk = v * v;
        const int64_t c[8] = {b, b + 1, b + 1 + v, b + v, b + dk, b + dk + 1, b + dk + 1 + v, b + dk + v};
        for (int a = 0; a < 8; ++a) ids[8 * q + a] = c[a];
      }
  srand(1);
  for (int i = 0; i < 3 * count; ++i) p[i] = n * (rand() / (double)RAND_MAX);
  insitu_session_options o = insitu_session_options_default();
  o.threads = 1;
  insitu_session s = NULL; insitu_mesh m = NULL;
  if (insitu_session_open(&o, &s)) return 1;
  insitu_session_mesh(s, "m", &m);
  insitu_array pts = insitu_array_of(x, INSITU_FLOAT64, v * v * v, 3);
  if (insitu_mesh_points(m, 0, &pts, 1)) { puts(insitu_last_message()); return 2; }
  insitu_cells c = insitu_cells_default();
  c.shape = INSITU_HEXAHEDRON; c.count = n * n * n;
  c.connectivity = insitu_array_of(ids, INSITU_INT64, n * n * n, 8);
  if (insitu_mesh_cells(m, 0, &c)) { puts(insitu_last_message()); return 3; }
  insitu_array fa = insitu_array_of(f, INSITU_FLOAT64, v * v * v, 1);
  insitu_mesh_field(m, 0, "f", INSITU_VERTEX, &fa, 1);
  if (insitu_mesh_commit(m, NULL)) { puts(insitu_last_message()); return 4; }
  insitu_sample_args a = insitu_sample_args_default();
  insitu_array pa = insitu_array_of(p, INSITU_FLOAT64, count, 3);
  a.locate.points = &pa;
  const char* const names[] = {"f"};
  double* const values[] = {out};
  a.fields = names; a.field_count = 1; a.values = values;
  for (int r = 0; r < 2; ++r)
    if (insitu_mesh_sample(m, &a)) { puts(insitu_last_message()); return 5; }
  printf("%g\n", out[0]);
  insitu_session_close(&s);
  return 0;
}
