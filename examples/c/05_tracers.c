/* 05: tracers. The scene asks for particles that follow the live velocity field from step to step;
 * the solver does nothing but execute. Tracks are in insitu_out/drifters*. */
#include <insitu/insitu.h>

#include <stdio.h>

enum { n = 17, cells_along = n - 1 };

static const char scene[] =
    "insitu: 1\n"
    "output: insitu_out\n"
    "tracers:\n"
    "  - name: drifters\n"
    "    kind: pathline\n"
    "    velocity: velocity\n"
    "    seeds: {line: {from: [0.2, 0, 0], to: [0.8, 0, 0], count: 4}}\n"
    "    output: [csv, vtp]\n";

static double u[n][n][n], v[n][n][n], w[n][n][n]; /* [k][j][i] */

int main(void) {
  insitu_session_options options = insitu_session_options_default();
  options.scene_text = scene;
  insitu_session session = NULL;
  insitu_mesh mesh = NULL;
  if (insitu_session_open(&options, &session) != INSITU_OK) {
    fprintf(stderr, "%s\n", insitu_last_message());
    return 1;
  }
  insitu_session_mesh(session, "flow", &mesh);
  insitu_block block = insitu_block_default(); /* the box from -1 to 1 */
  block.kind = INSITU_BLOCK_UNIFORM;
  for (int a = 0; a < 3; ++a) {
    block.vertices[a] = n;
    block.origin[a] = -1.0;
    block.spacing[a] = 2.0 / cells_along;
  }
  insitu_mesh_block(mesh, 0, &block);
  const insitu_array velocity[3] = {insitu_array_of(u, INSITU_FLOAT64, n * n * n, 1),
                                    insitu_array_of(v, INSITU_FLOAT64, n * n * n, 1),
                                    insitu_array_of(w, INSITU_FLOAT64, n * n * n, 1)};
  insitu_mesh_field(mesh, 0, "velocity", INSITU_VERTEX, velocity, 3);

  for (int cycle = 0; cycle <= 20; ++cycle) {
    const double time = 0.1 * cycle;
    for (int k = 0; k < n; ++k) /* a rotation around z that grows with time */
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          u[k][j][i] = -time * (-1.0 + 2.0 * j / cells_along);
          v[k][j][i] = time * (-1.0 + 2.0 * i / cells_along);
        }
    insitu_mesh_changed(mesh, INSITU_CHANGED_FIELDS);
    if (insitu_session_execute(session, cycle, time) != INSITU_OK) {
      fprintf(stderr, "cycle %d: %s\n", cycle, insitu_last_message());
      return 1;
    }
  }
  insitu_report report = insitu_report_default();
  insitu_session_report(session, &report);
  printf("%d particles, %d still alive after 20 steps\n", (int)report.particles_seeded,
         (int)report.particles[INSITU_END_ALIVE]);
  const int wrong = report.particles_seeded != 4 || report.particles[INSITU_END_ALIVE] != 4;
  return insitu_session_close(&session) != INSITU_OK || wrong;
}
